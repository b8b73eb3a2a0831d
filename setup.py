# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

from glob import glob
import os
from pathlib import Path
import shutil
import subprocess
import sys
import warnings

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext
from setuptools.errors import CompileError

try:
    from setuptools.command.bdist_wheel import bdist_wheel
except ImportError:  # setuptools up to 70
    from wheel.bdist_wheel import bdist_wheel

# Said of every editable installation, whatever is installed.
warnings.filterwarnings('ignore', 'Editable installation')

package_name = 'gearbox_monitor'
HAVE_COMPILER = bool(os.environ.get('CC')) or any(map(shutil.which, ('cc', 'gcc', 'clang')))


class Kernels(build_ext):
    """Compile kernels to plain shared libraries, without Python.h; see kernels/build.py."""

    def build_extension(self, ext):
        target = Path(self.get_ext_fullpath(ext.name)).absolute()
        paths = [str(Path(__file__).parent.absolute()), *filter(None, sys.path)]
        run = subprocess.run(
            [sys.executable, '-m', 'gearbox_monitor.kernels.build', str(target.parent),
             target.stem], check=False, cwd=target.anchor,
            env={**os.environ, 'PYTHONPATH': os.pathsep.join(paths),
                 'GEARBOX_MONITOR_KERNELS': ''})
        if run.returncode:  # goes on: the first start says what to install
            raise CompileError('kernels are not compiled')

    def get_ext_filename(self, name):
        return os.path.join(*name.split('.')) + '.so'


class Wheel(bdist_wheel):
    """A wheel for any Python of this machine."""

    def get_tag(self):
        return 'py3', 'none', super().get_tag()[2]


setup(
    name=package_name,
    version='0.2.0',
    packages=find_packages(exclude=['benchmarks', 'benchmarks.*', 'test', 'test.*']),
    package_data={package_name: [
        'py.typed', '*.toml', '*/*.toml', 'kernels/translate/prelude.h',
        'recordings/vocabulary.yaml', 'simulators/firmware/*',
        'report/assets/*', 'report/templates/*.html', 'report/templates/*/*.html']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', sorted(glob('config/*.*'))),
        ('share/' + package_name + '/config/actuators', sorted(glob('config/actuators/*.yaml'))),
        ('share/' + package_name + '/config/import', sorted(glob('config/import/*.yaml'))),
        ('share/' + package_name + '/config/security', sorted(glob('config/security/*.xml'))),
        ('share/' + package_name + '/launch',
         sorted(glob('gearbox_monitor/ros/launch/*.launch.py'))),
    ],
    python_requires='>=3.11',
    # What pip can bring. ROS packages are not named here: on an apt-installed Jazzy they have
    # no such names; in a plain venv the extra "ros" brings them as wheels.
    install_requires=[
        'Jinja2>=3.1',
        'mcap>=1.1',
        'numpy>=1.26',
        'PyYAML>=6.0',
        'rosbags>=0.10',
        'scipy>=1.11',
        'setuptools',
        'tqdm>=4.60',
    ],
    extras_require={
        # "fleet", Parquet and Feather files: 170 MB; no rosdep keys
        'tables': ['pyarrow>=14.0.1'],
        # "fleet --scheduler", too; dask and distributed have no rosdep keys
        'fleet': ['dask>=2024.1', 'distributed>=2024.1', 'pyarrow>=14.0.1'],
        # "export", and models read from MJCF files; no rosdep key
        'mujoco': ['mujoco>=4.0'],
        # to_frame of results
        'frames': ['pandas>=2.0'],
        # "import" of HDF5 and MATLAB 7.3 files
        'import': ['h5py>=3.10'],
        # "python -m benchmarks bam", Python 3.12; no rosdep key
        'bam': ['better-actuator-models>=1.0; python_version>="3.12"'],
        'ros': ['ros-jazzy-rclpy[fastrtps]', 'ros-jazzy-common-interfaces'],
        'test': [
            'codespell>=2.3',
            'distributed>=2024.1',
            'djlint>=1.34',
            'esprima>=4.0',
            'filterpy>=1.4',
            'flake8-import-order>=0.18',
            'h5py>=3.10',
            'mcap-ros2-support>=0.5',
            'mujoco>=4.0',
            'mypy>=1.11,<3',
            'pandas>=2.0',
            'psutil>=5.9',
            'pyarrow>=14.0.1',
            'pytest>=7.4',
            'pytest-timeout>=2.2',
            'pytest-cov>=5',
            'pytest-xdist>=3.3',
            'ruff>=0.6,<1',
            'selenium>=4.11',
            'tinycss2>=1.2',
        ],
    },
    # Of the two, the one for this processor is built, and both for packages that are handed on.
    ext_modules=[Extension(f'{package_name}.{stem}', [], optional=True)
                 for stem in ('_kernels_v3', '_kernels')],
    cmdclass={'build_ext': Kernels, 'bdist_wheel': Wheel},
    # Kernels are imported to be compiled; without a compiler on the machine pip brings one.
    setup_requires=['numpy>=1.26', *([] if HAVE_COMPILER else ['ziglang'])],
    zip_safe=False,
    maintainer='gearbox_monitor maintainers',
    maintainer_email='maintainers@gearbox-monitor.org',
    description='Online condition monitor for robot joint gearboxes',
    license='Apache-2.0',  # without a classifier: newer setuptools warn of it
    license_files=['LICENSE'],
    keywords=['ROS', 'robotics', 'condition monitoring', 'backlash', 'Kalman filter'],
    classifiers=[
        'Development Status :: 4 - Beta',
        'Intended Audience :: Manufacturing',
        'Intended Audience :: Science/Research',
        'Operating System :: POSIX :: Linux',
        'Programming Language :: Python :: 3',
        'Programming Language :: Python :: 3.11',
        'Programming Language :: Python :: 3.12',
        'Programming Language :: Python :: 3.13',
        'Topic :: Scientific/Engineering',
    ],
    entry_points={
        'console_scripts': [
            'gearbox_monitor = gearbox_monitor.cli.main:main',
            'plant_node = gearbox_monitor.ros.plant_node:main',
            'arm_plant_node = gearbox_monitor.ros.arm_plant_node:main',
            'estimator_node = gearbox_monitor.ros.estimator_node:main',
            'recorder_node = gearbox_monitor.ros.recorder_node:main',
            'watch_node = gearbox_monitor.ros.watch_node:main',
        ],
    },
)
