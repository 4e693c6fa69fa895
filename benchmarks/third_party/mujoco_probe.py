"""A probe on tissue in MuJoCo: a tip on a slide joint, a tendon as load cell.

Contents: the model, and its simulation.

The coil is a slide joint whose position, speed and acceleration are set at every step. A fixed
tendon joins it to the tip: its stiffness and damping are the load cell's, its length is u - x. The
tissue is a fixed tendon, too, between the tip and a floor (which moves where that is hidden); or,
where contact can be lost, a plate on a spring and damper of its own, which a stiff contact meets.

| hidden | MuJoCo | names of the library, family |
|---|---|---|
| friction | `frictionloss` of the tip's joint | coulomb_friction, friction |
| armature | `armature` of the tip's joint | added_mass, inertia |
| mode | a body on a slide joint with stiffness and damping, on the tip | structural_mode, inertia |
| branch | an actuator on the tip, whose activation follows the tip through a filter | \
standard_linear_solid, relaxation |
| guy wires | two spatial tendons across the motion, slack at rest | cubic_stiffening, stiffening |
| contact | sphere on the plate of 0.2 g, stiff contact | contact_loss, contact |
| play | `springlength` of the load cell's tendon is a range | backlash, lost motion |
| body motion | the floor under the tissue moves | tissue_motion, body motion |

The actuator pushes with k1 (z - x), where the activation z follows z' = (x - z) / time: a spring in
series with a damper, without a node between them.

Solver: RK4, steps of 5e-5 s, Newton's method with a tolerance of 1e-12, elliptic cones. Constraints
are as stiff as four steps allow (solref 2e-4 s, damping ratio 1; solimp 0.999), so that friction
and contact give way by less than the noise. A test halves the step.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from benchmarks.protocols.course import Array, Course

STEP = 5e-5
#: A coil so heavy that nothing moves it within a step [kg].
HEAVY = 1e6
#: Mass of the plate [kg], and the largest damping under it at which RK4 is stable [N s/m].
LIGHT = 2e-4
MOST_DAMPING = 0.5 * LIGHT / STEP
#: Half the length of the wires across [m].
WIRE = 5e-3


@dataclass(frozen=True)
class Probe:
    """Values of the model [SI]; 0 where there is no such part.

    Attributes
    ----------
    stiffness, damping, mass : float
        Of tissue and tip.
    cell_stiffness, cell_damping : float
        Of the load cell; 0 where a force drives.
    friction, armature : float
        Of the tip's joint [N], [kg].
    mode_mass, mode_stiffness, mode_damping : float
        Of the body on the tip.
    branch_stiffness, branch_time : float
        Of the actuator, and of its filter.
    wires : float
        Stiffness of each tendon across [N/m].
    one_sided : bool
        Whether the tissue is a plate that the tip may leave.
    play : float
        Half the range of the load cell's tendon [m].
    floor_amplitude, floor_frequency : float
        Of the floor's motion [m], [Hz].
    """

    stiffness: float
    damping: float
    mass: float
    cell_stiffness: float = 0.0
    cell_damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    mode_mass: float = 0.0
    mode_stiffness: float = 0.0
    mode_damping: float = 0.0
    branch_stiffness: float = 0.0
    branch_time: float = 1.0
    wires: float = 0.0
    one_sided: bool = False
    play: float = 0.0
    floor_amplitude: float = 0.0
    floor_frequency: float = 1.0

    @property
    def driven_by_force(self) -> bool:
        """Whether there is no load cell: a force acts on the tip."""
        return self.cell_stiffness == 0.0

    def xml(self, step: float) -> str:
        """Return the model."""
        joint = '<joint name="{}" type="slide" axis="1 0 0" {}/>'
        ball = '<geom type="sphere" size="0.001" mass="{}" contype="0" conaffinity="0"/>'

        def body(name: str, mass: float, more: str = "", inside: str = "", geom: str = ball) -> str:
            return f"<body>{joint.format(name, more)}{geom.format(mass)}{inside}</body>"

        inside, tendons, bodies = '<site name="tip" pos="0 0 0"/>', [], []
        if self.mode_mass:
            spring = f'stiffness="{self.mode_stiffness}" damping="{self.mode_damping}"'
            inside += body("mode", self.mode_mass, spring)
        stiff = f'solref="{4 * step} 1" solimp="0.999 0.999 0.0001"'
        touching = f'<geom type="sphere" size="0.001" mass="{{}}" {stiff}/>'
        more = f'frictionloss="{self.friction}" armature="{self.armature}"'
        more += f' solreffriction="{4 * step} 1" solimpfriction="0.999 0.999 0.0001"'
        bodies.append(body("tip", self.mass, more, inside, touching if self.one_sided else ball))
        if self.one_sided:
            spring = f'stiffness="{self.stiffness}" damping="{self.damping}"'
            plate = f'<geom type="box" pos="0.002 0 0" size="0.001 0.01 0.01" mass="{{}}" {stiff}/>'
            bodies.append(body("plate", LIGHT, spring, geom=plate))
        else:
            bodies.append(body("floor", HEAVY))
            tendons.append(_between("floor", self.stiffness, self.damping))
        if not self.driven_by_force:
            bodies.append(body("coil", HEAVY))
            between = _between("coil", self.cell_stiffness, self.cell_damping, self.play)
            tendons.append(between)
        branch = ""
        if self.branch_stiffness:
            gain = self.branch_stiffness
            branch = (
                f'<actuator><general joint="tip" dyntype="filter" dynprm="{self.branch_time}" '
                f'gainprm="{gain}" biastype="affine" biasprm="0 {-gain} 0"/></actuator>'
            )
        if self.wires:
            for side in (-WIRE, WIRE):
                name = f"pole{'+' if side > 0 else '-'}"
                bodies.append(f'<site name="{name}" pos="0 {side} 0"/>')
                tendons.append(
                    f'<spatial stiffness="{self.wires}" springlength="{WIRE}">'
                    f'<site site="tip"/><site site="{name}"/></spatial>'
                )
        contact = "" if self.one_sided else '<flag contact="disable"/>'
        return (
            f'<mujoco><option timestep="{step}" gravity="0 0 0" integrator="RK4" solver="Newton" '
            f'tolerance="1e-12" cone="elliptic">{contact}</option>'
            f"<worldbody>{''.join(bodies)}</worldbody><tendon>{''.join(tendons)}</tendon>"
            f"{branch}</mujoco>"
        )


def _between(name: str, stiffness: float, damping: float, play: float = 0.0) -> str:
    return (
        f'<fixed stiffness="{stiffness}" damping="{damping}" springlength="{-play} {play}">'
        f'<joint joint="{name}" coef="1"/><joint joint="tip" coef="-1"/></fixed>'
    )


def simulate(probe: Probe, course: Course, times: Array, step: float = STEP) -> tuple[Array, Array]:
    """Return the tip's position [m] and the load cell's force [N], from rest at time 0.

    Parameters
    ----------
    probe : Probe
        The model.
    course : Course
        Of the coil [m]; where there is no load cell, of the force on the tip [N].
    times : array
        Of the samples [s]: multiples of the step.
    step : float
        Of the simulation [s].
    """
    model = mujoco.MjModel.from_xml_string(probe.xml(step))
    data = mujoco.MjData(model)
    at = {name: model.joint(name).qposadr[0] for name in _joints(model)}
    steps = np.round(times / step).astype(int)
    clock = step * np.arange(steps[-1] + 1)
    # A force is held within a step, so that its middle counts.
    middle, orders = (0.5 * step, 1) if probe.driven_by_force else (0.0, 3)
    drive = np.stack([course(clock + middle, order) for order in range(orders)], axis=-1)
    angle = 2.0 * np.pi * probe.floor_frequency
    places, tip = np.empty(clock.size), at["tip"]
    for number, driven in enumerate(drive):
        if probe.driven_by_force:
            data.qfrc_applied[tip] = driven[0]
        else:
            _set(data, at["coil"], *driven)
        if probe.floor_amplitude:
            phase = angle * clock[number]
            wave = probe.floor_amplitude * np.array([np.sin(phase), np.cos(phase), -np.sin(phase)])
            _set(data, at["floor"], *(wave * angle ** np.arange(3)))
        places[number] = data.qpos[tip]
        data.ctrl[:] = data.qpos[tip]
        mujoco.mj_step(model, data)
    stretch = drive[steps, 0] - places[steps]
    stretch = np.sign(stretch) * np.maximum(np.abs(stretch) - probe.play, 0.0)
    return places[steps], probe.cell_stiffness * stretch


def _joints(model: mujoco.MjModel) -> list[str]:
    return [model.joint(number).name for number in range(model.njnt)]


def _set(data: mujoco.MjData, at: int, place: float, speed: float, acceleration: float) -> None:
    """Put a heavy body where it has to be, and let it go on as it should within the step."""
    data.qpos[at], data.qvel[at] = place, speed
    data.qfrc_applied[at] = HEAVY * acceleration
