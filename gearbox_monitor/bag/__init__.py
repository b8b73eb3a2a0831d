"""rosbag2-compatible MCAP recordings: write, read, also after a crash."""
