from setuptools import setup

setup(
    name="slip_grip_action",
    version="0.1.0",
    packages=["slip_grip_action"],
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/slip_grip_action"]),
        ("share/slip_grip_action", ["package.xml"]),
    ],
    license="MIT OR Apache-2.0",
    entry_points={"console_scripts": ["gripper_action = slip_grip_action.node:main"]},
)
