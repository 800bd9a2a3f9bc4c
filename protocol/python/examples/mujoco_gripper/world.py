"""A parallel gripper and an object in MuJoCo: grip force in; contact forces, movement and slip out.

Two fingers on slides, joined so that they close evenly, each pressed by a drive of first order. Their pads give way sideways on springs; between
pad and object is MuJoCo's Coulomb friction with elliptic cones, and nothing creeps where it holds (:mod:`test_mujoco_gripper`). The hand lifts
the object from a table. Down is the direction of a slip.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np

from .items import Item
from .taxels import Array

STEP_S = 2e-4
LIFT_AFTER_S = 0.4
"""From touch to lift."""
LIFT_M, LIFT_S = 0.05, 0.8
LIFT_PEAK_M_S2 = 10.0 / math.sqrt(3.0) * LIFT_M / LIFT_S**2
"""Largest acceleration of the lift."""
SWAY_AT_S, SWAY_S = 1.1, 0.5
HOLD_S = 3.0
"""A grasp lasts so long from the lift on."""
DROPPED_M = 0.025
"""More slip than this, and the object is dropped."""
GAP_M = 0.001
STYLUS_Y_M = 0.003
"""The stylus stands beside the middle of the pad."""
OPENING_N = -0.4
DRIVE_LAG_S = 0.005
_PALM_KG = 1e5

_MODEL = """
<mujoco>
  <option timestep="{step}" integrator="Euler" cone="elliptic" impratio="20" noslip_iterations="4" iterations="8" tolerance="1e-8"><flag eulerdamp="disable"/></option>
  <visual><global offwidth="480" offheight="480"/><headlight ambient="0.4 0.4 0.4" diffuse="0.5 0.5 0.5"/></visual>
  <default>
    <default class="pad"><geom type="box" size="0.002 0.010 0.010" mass="0.005" contype="0" conaffinity="0" rgba="0.2 0.2 0.25 1"/></default>
    <default class="item"><geom friction="0.5 0.002 0.0001" condim="4" solref="0.002 1" rgba="0.85 0.55 0.25 1"/></default>
    <default class="rest"><geom friction="0.5 0.002 0.0001" condim="3" solref="0.002 1" rgba="0.85 0.55 0.25 0.4"/></default>
    <default class="fill"><geom type="sphere" contype="0" conaffinity="0" rgba="0.2 0.5 0.9 1"/></default>
    <default class="finger"><geom type="box" contype="0" conaffinity="0" rgba="0.6 0.62 0.66 1"/></default>
  </default>
  <asset>{assets}</asset>
  <worldbody>
    <light pos="0.2 -0.4 0.6" dir="-0.3 0.6 -1"/>
    <camera name="side" pos="0.05 -0.33 {camera}" xyaxes="1 0.15 0 0 0.2 1"/>
    <geom type="plane" size="0.3 0.3 0.01" friction="0.4 0.002 0.0001" rgba="0.9 0.9 0.88 1"/>
    <body name="palm" pos="0 0 {height}" gravcomp="1">
      <joint name="up" type="slide" axis="0 0 1" armature="{palm}"/>
      <joint name="aside" type="slide" axis="0 1 0" armature="{palm}"/>
      <geom class="finger" size="0.06 0.012 0.008" pos="0 0 0.07" mass="0.2"/>
      {fingers}
    </body>
    <body name="item" pos="0 {offset} {half}"><freejoint name="item"/>{xml}</body>
  </worldbody>
  <contact>{pairs}</contact>
  <equality><joint joint1="close1" joint2="close2" solref="0.002 1"/></equality>
  <actuator>
    <general joint="close1" dyntype="filterexact" dynprm="{lag}" gainprm="1" biastype="none"/>
    <general joint="close2" dyntype="filterexact" dynprm="{lag}" gainprm="1" biastype="none"/>
  </actuator>
  <sensor>
    <touch site="touch1"/><touch site="touch2"/>
    <framepos objtype="body" objname="item" reftype="body" refname="finger1"/>
    <framelinvel objtype="body" objname="item" reftype="body" refname="finger1"/>
    <frameangvel objtype="body" objname="item" reftype="body" refname="finger1"/>
    <jointpos joint="shear_y1"/><jointpos joint="shear_z1"/><jointpos joint="shear_z2"/>
  </sensor>
</mujoco>
"""

_FINGER = """
<body name="finger{k}" pos="{x} 0 0"{turn} gravcomp="1">
  <joint name="close{k}" type="slide" axis="1 0 0" damping="20" range="-0.02 0.03" limited="true"/>
  <geom class="finger" size="0.004 0.008 0.040" pos="-0.008 0 0.027" mass="0.1"/>
  <body name="pad{k}" pos="-0.002 0 0" gravcomp="1">
    <joint type="slide" axis="1 0 0" stiffness="{press}" damping="20"/>
    <joint name="shear_y{k}" type="slide" axis="0 1 0" stiffness="{shear}" damping="{damping}"/>
    <joint name="shear_z{k}" type="slide" axis="0 0 1" stiffness="{shear}" damping="{damping}"/>
    <geom class="pad" name="pad{k}"/>
    <site name="touch{k}" type="box" size="0.004 0.012 0.012" rgba="0 0 0 0"/>
  </body>
</body>
"""

_PAIR = '<pair geom1="pad{pad}" geom2="item{geom}" condim="4" friction="{mu} {mu} 0.002 0.0001 0.0001" solref="0.001 1" solimp="0.95 0.99 0.0001"/>'

PAD_SHEAR_N_M, PAD_PRESS_N_M = 5e4, 3e4
"""Stiffness of a pad along the surface and against it [N/m]. A stiff and heavy finger would lose touch: MuJoCo pushes apart what slides."""
FORCE_LAG_S = 0.5e-3
"""Of the force sensor: its amplifier has 300 Hz."""


def _eased(t: float) -> tuple[float, float, float]:
    """Way, speed and acceleration of a movement from 0 to 1 in unit time with the least jerk."""
    if not 0.0 < t < 1.0:
        return (0.0 if t <= 0.0 else 1.0), 0.0, 0.0
    return t**3 * (10 - 15 * t + 6 * t * t), 30 * t * t * (1 - t) ** 2, 60 * t * (1 - t) * (1 - 2 * t)


def _width(item: Item) -> float:
    """Half of the width between the fingers [m]."""
    classes = "".join(f'<default class="{name}"><geom{more}/></default>' for name, more in (("item", ""), ("rest", ""), ("fill", ' type="sphere"')))
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><default>{classes}</default><asset>{item.assets}</asset><worldbody><body>{item.xml}<freejoint/></body></worldbody></mujoco>"
    )
    widest = 0.0
    for k in range(model.ngeom):
        kind, size = model.geom_type[k], model.geom_size[k]
        if kind == mujoco.mjtGeom.mjGEOM_MESH:
            widest = max(widest, float(abs(model.mesh_vert[:, 0]).max()))
        else:
            widest = max(widest, abs(float(model.geom_pos[k][0])) + float(size[0]))
    return widest


def xml(item: Item) -> str:
    """The model of gripper, table and object in MJCF."""
    # An object of 1 kg swings on them at 50 Hz with a damping of 0.06, as on rubber. MuJoCo's implicit damping would take most of that away where
    # a light pad sticks to a heavy object, so the damping of joints is explicit.
    stiffness = {"shear": PAD_SHEAR_N_M, "damping": 20.0, "press": PAD_PRESS_N_M}
    half = _width(item) + GAP_M
    fingers = _FINGER.format(k=1, x=-half, turn="", **stiffness) + _FINGER.format(k=2, x=half, turn=' euler="0 0 180"', **stiffness)
    parts = item.xml.split('class="item"')
    named = parts[0] + "".join(f'class="item" name="item{k}"{part}' for k, part in enumerate(parts[1:]))
    pairs = "".join(_PAIR.format(pad=pad, geom=k, mu=item.friction) for pad in (1, 2) for k in range(len(parts) - 1))
    return _MODEL.format(
        step=STEP_S, pairs=pairs, assets=item.assets, palm=_PALM_KG, fingers=fingers, xml=named, lag=DRIVE_LAG_S,
        half=item.half_height_m, height=item.half_height_m, offset=item.offset_m, camera=item.half_height_m + 0.09,
    )  # fmt: skip


class World:
    """Gripper and object; one call of :meth:`step` is 0.2 ms."""

    def __init__(self, item: Item, array: Array | None = None) -> None:
        """``array`` is that of one pad, if it has one."""
        self.item = item
        self.array = array
        self.model = mujoco.MjModel.from_xml_string(xml(item))
        self.data = mujoco.MjData(self.model)
        self._body = self.model.body("item").id
        self._pad = self.model.geom("pad1").id
        self._up, self._aside = (int(self.model.jnt_qposadr[self.model.joint(name).id]) for name in ("up", "aside"))
        self._up_v, self._aside_v = (int(self.model.jnt_dofadr[self.model.joint(name).id]) for name in ("up", "aside"))
        self._hand_kg = _PALM_KG + float(self.model.body_subtreemass[self.model.body("palm").id])
        self.steps = 0
        self.force_n = self.shear_n = 0.0
        """Force of one finger against the object behind the sensor's lag, and what it holds along itself."""
        self.down_m = self.aside_m = 0.0
        """Way of the surface under the stylus, against the finger."""
        self.slip_m = self.peak_slip_m = 0.0
        """Way of the surface in the middle of the pad, against the pad, since the lift."""
        self.peak_n = 0.0
        self.touched_s: float | None = None
        self.dropped = self.released = False
        self._way = [0.0, 0.0]
        self._start = [0.0, 0.0]
        self._smooth_n = 0.0
        mujoco.mj_forward(self.model, self.data)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self.steps * STEP_S

    @property
    def since_lift_s(self) -> float:
        """Time since the lift began; below 0 before."""
        return -1.0 if self.touched_s is None else self.time_s - self.touched_s - LIFT_AFTER_S

    @property
    def is_over(self) -> bool:
        """Whether the object is dropped, or has been held for as long as a grasp lasts."""
        return self.dropped or self.since_lift_s >= HOLD_S

    def close(self, target_n: float) -> float:
        """The set point of fingers that close lightly and then press with ``target_n``, reached at 200 N/s."""
        if self.touched_s is None:
            return min(0.3, target_n)
        return min(target_n, 0.3 + 200.0 * (self.time_s - self.touched_s))

    def step(self, command_n: float) -> None:
        """Advances by one step with this set point of each finger's drive; below 0 the fingers open."""
        data = self.data
        data.ctrl[0] = data.ctrl[1] = command_n
        self._move_hand()
        mujoco.mj_step(self.model, data)
        self.steps += 1
        self._measure(data.sensordata.tolist())
        if self.array is not None:
            self.array.follow(*self.pad_forces(), STEP_S)

    def pad_forces(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the object presses on one pad, n x 2, across and along it from its middle [m], and with which forces [N]."""
        data = self.data
        touching = (data.contact.geom == self._pad).any(axis=1) & (data.contact.efc_address >= 0)
        # The first row of a contact with an elliptic cone is its normal force. The hand does not turn.
        return data.contact.pos[touching, 1:] - data.geom_xpos[self._pad, 1:], data.efc_force[data.contact.efc_address[touching]]

    def _move_hand(self) -> None:
        """The hand goes where it is led to, whatever it carries."""
        t = self.since_lift_s
        data = self.data
        moves = [(self._up, self._up_v, LIFT_M, t / LIFT_S, LIFT_S)]
        moves.append((self._aside, self._aside_v, self.item.sway_m, (t - SWAY_AT_S) / SWAY_S, SWAY_S))
        for at, dof, length, share, duration in moves:
            way, speed, acceleration = _eased(share)
            data.qpos[at], data.qvel[dof] = way * length, speed * length / duration
            data.qfrc_applied[dof] = self._hand_kg * acceleration * length / duration**2
        pull = self.item.pull
        data.xfrc_applied[self._body, 2] = -pull.at(t) if pull is not None and t > 0 else 0.0

    def _measure(self, read: list[float]) -> None:
        touch1, touch2, px, py, pz, vx, vy, vz, wx, wy, wz, shear_y, shear_z, other_z = read
        self.force_n += (0.5 * (touch1 + touch2) - self.force_n) * STEP_S / FORCE_LAG_S
        self.shear_n = -0.5 * (shear_z + other_z) * PAD_SHEAR_N_M
        # Speed of the object's surface: that of its centre plus the turn times the lever from there, under the stylus and in the middle.
        lever_y = STYLUS_Y_M - py
        self.down_m -= (vz + wx * lever_y + wy * px) * STEP_S
        self.aside_m += (vy - wz * px + wx * pz) * STEP_S
        way = self._way
        way[0] -= (vz - wx * py + wy * px) * STEP_S
        way[1] += (vy - wz * px + wx * pz) * STEP_S
        down, aside = way[0] + shear_z, way[1] - shear_y
        if self.touched_s is None:
            if min(touch1, touch2) > 0.02:
                self.touched_s = self.time_s
        self._smooth_n += (self.force_n - self._smooth_n) * STEP_S / 0.002
        if self.released:
            return
        self.peak_n = max(self.peak_n, self._smooth_n)
        if self.since_lift_s < 0.0:
            self._start = [down, aside]
        self.slip_m = math.hypot(down - self._start[0], aside - self._start[1])
        self.peak_slip_m = max(self.peak_slip_m, self.slip_m)
        self.dropped = self.dropped or self.slip_m > DROPPED_M
