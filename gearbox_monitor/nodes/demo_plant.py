"""The node `plant`, which here waits for estimator and recorder, so that they miss no sample."""
import sys
import time

from rclpy.duration import Duration

from gearbox_monitor.nodes.plant_node import PlantNode
from gearbox_monitor.nodes.runtime import spin_node

SUBSCRIBERS = 2  # of joint_states; the recorder alone has the truth
ACKNOWLEDGED = Duration(seconds=5)


class WaitingPlant(PlantNode):
    """
    Plant that goes on behind its first sample when all subscribers have acknowledged it.

    A publisher knows its subscribers before these know the publisher, at worst for 3 s.
    """

    def _work(self):
        if self._start is None and (
                self._states_out.get_subscription_count() < SUBSCRIBERS
                or not self._truth_out.get_subscription_count()):
            return
        super()._work()

    def _publish(self, *row):
        super()._publish(*row)
        if self.count == 0:
            for publisher in (self._states_out, self._truth_out):
                publisher.wait_for_all_acked(ACKNOWLEDGED)
            self._start = time.monotonic_ns()


def main(args=None):
    """Run the node; return the exit code."""
    return spin_node(WaitingPlant, args, __doc__)


if __name__ == '__main__':
    sys.exit(main())
