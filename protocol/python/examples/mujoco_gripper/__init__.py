"""MuJoCo in the loop: contact physics that this project did not write, at the other end of the serial link of gripd.

``python -m mujoco_gripper --gripd PATH`` (see ``README.md``). The parts: :mod:`items` draws objects, :mod:`world` is gripper and object in MuJoCo,
:mod:`surface` heights, stylus and sensor noise, :mod:`needed` what an object needs and what an oracle holds, :mod:`loop` gripd in real time,
:mod:`table` and :mod:`trace` what is printed and drawn.
"""
