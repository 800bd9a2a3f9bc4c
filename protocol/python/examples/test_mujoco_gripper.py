"""The world of mujoco_gripper against closed formulas, and its device against a host of the link. Run by scripts/mujoco-check.sh."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from grip_link import Config, GripLink, VirtualMcu
from mujoco_gripper import surface, taxels
from mujoco_gripper.items import CLASSES, GRAVITY, Item, draw
from mujoco_gripper.loop import Gripper, ident
from mujoco_gripper.needed import hold, needed_n
from mujoco_gripper.table import wilson
from mujoco_gripper.world import LIFT_PEAK_M_S2, PAD_SHEAR_N_M, STEP_S, World

SEED = 3


def held_for(world: World, force_n: float, until_s: float) -> Iterator[World]:
    """The world after each step until so long after the lift."""
    while world.since_lift_s < until_s:
        world.step(world.close(force_n))
        yield world


def box() -> Item:
    return draw("box", SEED, 0)


def test_a_box_needs_what_coulomb_friction_says() -> None:
    item = box()
    wanted = item.mass_kg * (GRAVITY + LIFT_PEAK_M_S2) / (2.0 * item.friction)
    assert needed_n(item) == pytest.approx(wanted, rel=0.05)
    assert hold(item, 0.9 * wanted, 1.0).slip_m > 1e-3


def test_a_bar_gripped_beside_its_middle_needs_more_and_turns_with_less() -> None:
    item = draw("off_centre", SEED, 4)
    needed = needed_n(item)
    assert 1.1 * item.weight_force_n < needed < 3.0 * item.weight_force_n
    world = World(item)
    for _ in held_for(world, item.weight_force_n, 0.5):
        pass
    turn_rad = 2.0 * np.arcsin(world.data.joint("item").qpos[4])
    assert abs(turn_rad) > 0.02 and world.peak_slip_m > 5e-4


@pytest.mark.parametrize("kind", ["cylinder", "off_centre"])
def test_what_is_held_does_not_creep(kind: str) -> None:
    item = draw(kind, SEED, CLASSES.index(kind))
    world = World(item)
    force = 1.1 * needed_n(item)
    slips = [world.slip_m for _ in held_for(world, force, 2.5) if world.since_lift_s > 2.0]
    assert abs(slips[-1] - slips[0]) / 0.5 < 2e-6
    assert world.force_n == pytest.approx(force, rel=0.02)


@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_what_slides_is_braked_as_coulomb_friction_says(kind: str) -> None:
    item = draw(kind, SEED, CLASSES.index(kind))
    world, ways = World(item), []
    held = item.weight_force_n
    # It stays behind on the table, faster and faster, until twice the force that holds it comes within 25 ms (the drive and its ramp).
    while world.since_lift_s < 0.3:
        world.step(world.close(0.4 * held if world.since_lift_s < 0.15 else 2.0 * held))
        ways.append((world.since_lift_s, world.slip_m))
    speed = next((b[1] - a[1]) / (b[0] - a[0]) for a, b in zip(ways[::5], ways[5::5]) if b[0] > 0.15)
    last = ways[-1][1]
    still = next(since for since, way in ways if since > 0.15 and abs(way - last) < 2e-5)
    assert speed > 0.02
    assert still - 0.15 < 0.025


def test_what_swings_on_its_pads_comes_to_rest_as_on_rubber() -> None:
    """A mode of mass m on two pads of c and k each is damped by 2 c / (2 sqrt(2 k m))."""
    item = draw("cylinder", SEED, 9)
    world, ways = World(item), []
    while world.since_lift_s < 0.4:
        world.step(world.close((0.5 if world.since_lift_s < 0.12 else 4.0) * item.weight_force_n))
        ways.append((world.since_lift_s, world.down_m))
    swing = [np.ptp([way for since, way in ways if begin < since < begin + 0.02]) for begin in (0.2, 0.26)]
    omega = np.sqrt(2.0 * PAD_SHEAR_N_M / item.mass_kg)
    damping = np.log(swing[0] / swing[1]) / (omega * 0.06)
    assert damping == pytest.approx(20.0 / np.sqrt(2.0 * PAD_SHEAR_N_M * item.mass_kg), rel=0.35)


@pytest.mark.parametrize("kind", ["box", "cylinder"])
def test_the_force_on_what_slides_is_that_of_the_drive(kind: str) -> None:
    item = draw(kind, SEED, CLASSES.index(kind))
    force = 0.4 * item.weight_force_n
    forces = [world.force_n for world in held_for(World(item), force, 0.35) if world.since_lift_s > 0.05]
    assert np.mean(forces) == pytest.approx(force, rel=0.02) and np.std(forces) < 0.4 * force and min(forces) > 0.1 * force


@pytest.mark.parametrize("number", range(len(CLASSES)))
def test_every_class_is_touched_at_rest(number: int) -> None:
    world = World(draw(CLASSES[number % len(CLASSES)], SEED, number))
    for _ in range(round(0.2 / STEP_S)):
        world.step(0.3)
    assert world.touched_s is not None and world.peak_n < 1.0
    assert world.force_n == pytest.approx(0.3, abs=0.02)


def test_the_way_under_the_stylus_is_that_of_the_hand_while_a_box_stays_behind() -> None:
    world = World(box())
    for _ in held_for(world, 0.3, 0.3):
        pass
    assert world.down_m == pytest.approx(float(world.data.joint("up").qpos[0]), abs=3e-5)


def test_a_profile_has_its_mean_deviation_and_no_waves_beyond_its_band() -> None:
    heights = surface.profile(np.random.default_rng(1), 2e-6)
    assert np.abs(heights - heights.mean()).mean() == pytest.approx(2e-6, rel=1e-9)
    power = np.abs(np.fft.rfft(heights)) ** 2
    wave = np.fft.rfftfreq(surface.POINTS, surface.PITCH_M)
    assert power[wave > 1.01 / surface.SHORTEST_M].sum() < 1e-12 * power.sum()
    assert power[(wave > 0) & (wave < 4e3)].sum() > 0.8 * power.sum()


def test_the_stylus_rests_on_the_surface_and_loses_what_is_too_fast() -> None:
    def gain(hertz: float) -> float:
        stylus = surface.Stylus()
        read = [stylus.follow(1e-4, np.sin(2.0 * np.pi * hertz * k * 1e-4)) for k in range(3000)]
        return float(max(read[1500:]))

    assert gain(20.0) == pytest.approx(1.0, abs=0.01)
    assert gain(4000.0) < 0.3


def test_the_array_has_all_of_the_force_and_has_it_where_it_acts() -> None:
    places = np.array([[-7.5e-3, 2.5e-3], [9e-3, -9e-3]])
    each = [taxels.pressures(places[k : k + 1], np.array([force])) * taxels.AREA_M2 for k, force in enumerate((2.0, 3.0))]
    assert each[0].sum() == pytest.approx(2.0) and each[1].sum() == pytest.approx(3.0)
    # Rows lie along the finger from below, columns across it.
    assert divmod(int(each[0].argmax()), taxels.SIDE) == (2, 0) and divmod(int(each[1].argmax()), taxels.SIDE) == (0, 3)
    assert taxels.pressures(places, np.array([2.0, 3.0])) * taxels.AREA_M2 == pytest.approx(each[0] + each[1])
    assert not taxels.pressures(np.empty((0, 2)), np.empty(0)).any()


@pytest.mark.parametrize("kind", ["box", "cylinder", "round"])
def test_the_array_shows_the_grip_force(kind: str) -> None:
    item, array = draw(kind, SEED, CLASSES.index(kind)), taxels.Array()
    world = World(item, array)
    force = 1.5 * item.weight_force_n
    for _ in held_for(world, force, 0.0):
        pass
    assert array.pressures_pa.sum() * taxels.AREA_M2 == pytest.approx(force, rel=0.02)


def test_the_pattern_goes_with_the_edge_of_a_box_that_stays_behind() -> None:
    array = taxels.Array()
    world = World(box(), array)
    rows: list[float] = []
    for _ in held_for(world, 0.3, 0.7):
        along = array.pressures_pa.reshape(taxels.SIDE, taxels.SIDE).sum(axis=1)
        rows.append(float(along @ np.arange(taxels.SIDE) / along.sum()) if along.any() else np.nan)
        if world.slip_m > 0.9 * box().half_height_m:
            break
    still = rows[round(0.3 / STEP_S)]
    assert still == pytest.approx(1.5, abs=0.1)
    assert rows[-1] < still - 0.3


class Line:
    """A stream in simulated time, 100 us a turn, so that no busy machine is in it; the gripper turns while the host waits."""

    def __init__(self) -> None:
        self.now_us, self.wire, self.other, self.turn = 0, b"", self, lambda: None

    def read(self, timeout_s: float) -> bytes:
        if timeout_s > 0.0:
            self.other.now_us = self.now_us = self.now_us + 100
            self.turn()
        wire, self.wire = self.wire, b""
        return wire

    def write(self, data: bytes) -> int:
        self.other.wire += data
        return len(data)

    def close(self) -> None:
        pass


def read_by_a_host(sensors: str) -> np.ndarray:
    """Rows of a box held with 0.5 N."""
    gripper, near, far = Gripper(box(), sensors, 0.0), Line(), Line()
    near.other, far.other = far, near
    mcu = VirtualMcu(far, gripper.sense, gripper.drive, ident=ident(gripper.kinds), clock_us=lambda: far.now_us)
    near.turn = mcu.step
    link = GripLink(near, Config(sample_rate_hz=10_000, batch=10), clock_us=lambda: near.now_us)
    link.connect()
    rows = []
    for sample in link.samples(0.4):
        rows.append(sample.values)
        if len(rows) % 100 == 0:
            link.grip(0.5)
    assert link.ident is not None and link.ident.uid == b"mujoco-gripper\0\0"
    assert len(rows) > 3500
    return np.array(rows)


def test_the_device_answers_a_host_with_what_the_sensors_read() -> None:
    read = read_by_a_host("travel")
    assert read.shape[1] == 3
    assert read[-500:, 1].mean() == pytest.approx(0.5, abs=0.01)
    assert read[-500:, 2].std() == pytest.approx(surface.TRAVEL_NOISE_M, rel=0.2)
    assert read[-500:, 0].std() == pytest.approx(surface.STYLUS_NOISE_M, rel=0.2)


def test_a_host_reads_a_frame_of_the_array_each_millisecond() -> None:
    read = read_by_a_host("taxels")
    assert read.shape[1] == 2 + taxels.TAXELS
    frames = read[-1000:, 2:]
    changes = np.flatnonzero((np.diff(frames, axis=0) != 0.0).any(axis=1))
    assert set(np.diff(changes)) == {10}
    assert frames.sum(axis=1).mean() * taxels.AREA_M2 == pytest.approx(0.5, abs=0.02)
    assert frames[changes].std(axis=0).mean() == pytest.approx(taxels.NOISE_PA, rel=0.25)


def test_the_tangential_force_is_what_a_finger_carries() -> None:
    item = box()
    world = World(item)
    for _ in held_for(world, 1.5 * needed_n(item), 1.2):
        pass
    assert world.shear_n == pytest.approx(0.5 * item.mass_kg * GRAVITY, rel=0.02)


@pytest.mark.parametrize(("hits", "of"), [(1, 20), (7, 20), (150, 152)])
def test_the_interval_ends_where_the_count_is_196_deviations_away(hits: int, of: int) -> None:
    for share in wilson(hits, of):
        assert abs(hits - of * share) == pytest.approx(1.96 * np.sqrt(of * share * (1.0 - share)), rel=1e-6)


def test_the_interval_of_none_begins_at_none() -> None:
    assert wilson(0, 20) == (0.0, pytest.approx(0.161, abs=1e-3)) and wilson(20, 20)[1] == 1.0


def test_the_fingers_take_the_weight_from_the_table_as_the_hand_lifts() -> None:
    item = draw("cylinder", SEED, CLASSES.index("cylinder"))
    world = World(item)
    shares = {}
    for _ in held_for(world, 1.5 * needed_n(item), 0.5):
        contact = world.data.contact
        table = contact.efc_address[(contact.geom == 0).any(axis=1) & (contact.efc_address >= 0)]
        weight = item.mass_kg * GRAVITY
        shares[round(world.since_lift_s, 4)] = (world.data.efc_force[table].sum() / weight, 2.0 * world.shear_n / weight)
    assert shares[-0.0002] == pytest.approx((1.0, 0.0), abs=0.05)
    at_once = [table for since, (table, _) in shares.items() if 0.0 < since < 0.02]
    assert min(at_once) > 0.5 and max(table for since, (table, _) in shares.items() if since > 0.1) == 0.0
    assert shares[0.3][1] == pytest.approx(1.0, abs=0.1)
