# Nodes and commands on an apt-installed Jazzy; docs/install.md.
FROM ros:jazzy-ros-base

# Some rosdep keys are pip packages.
ENV PIP_BREAK_SYSTEM_PACKAGES=1 PIP_NO_CACHE_DIR=1
WORKDIR /ws
COPY package.xml src/gearbox_monitor/
RUN apt-get update \
 && apt-get install -y --no-install-recommends python3-pip \
 && rosdep update --rosdistro jazzy \
 && rosdep install --from-paths src -iy --rosdistro jazzy --dependency-types=build --dependency-types=exec \
 && rm -rf /var/lib/apt/lists/*

COPY . src/gearbox_monitor
RUN . /opt/ros/jazzy/setup.sh && GEARBOX_MONITOR_PORTABLE=1 colcon build

# Bags, pages and the state of the monitor.
VOLUME /data
WORKDIR /data
ENTRYPOINT ["bash", "-c", "source /ws/install/setup.bash && exec \"$@\"", "--"]
CMD ["ros2", "launch", "gearbox_monitor", "monitor.launch.py"]
