# Nodes and commands on an apt-installed Jazzy; docs/install.md.
FROM ros:jazzy-ros-base

# Some rosdep keys are pip packages, and numba is no package of Ubuntu 24.04.
ENV PIP_BREAK_SYSTEM_PACKAGES=1 PIP_NO_CACHE_DIR=1
WORKDIR /ws
COPY package.xml src/gearbox_monitor/
RUN apt-get update \
 && apt-get install -y --no-install-recommends python3-pip \
 && rosdep update --rosdistro jazzy \
 && rosdep install --from-paths src -iy --rosdistro jazzy --dependency-types=exec \
 && pip install numba \
 && rm -rf /var/lib/apt/lists/*

COPY . src/gearbox_monitor
RUN . /opt/ros/jazzy/setup.sh && colcon build
RUN . install/setup.sh && NUMBA_CACHE_DIR=/ws/kernels ros2 run gearbox_monitor gearbox_monitor compile \
 && chmod -R a+rX /ws/kernels

# Bags, pages and the state of the monitor; the cache takes the kernels of the image where
# it is writable, and others.
VOLUME /data
WORKDIR /data
ENV NUMBA_CACHE_DIR=/data/.cache
ENTRYPOINT ["bash", "-c", "source /ws/install/setup.bash && { mkdir -p \"$NUMBA_CACHE_DIR\" && cp --update=none /ws/kernels/* \"$NUMBA_CACHE_DIR\"; exec \"$@\"; }", "--"]
CMD ["ros2", "launch", "gearbox_monitor", "monitor.launch.py"]
