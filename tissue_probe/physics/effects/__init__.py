"""Physical effects beyond Kelvin-Voigt tissue. A new one is a file here and a line below."""

from tissue_probe.physics.effects.added_mass import ADDED_MASS
from tissue_probe.physics.effects.adhesion import ADHESION
from tissue_probe.physics.effects.adhesion_within_range import ADHESION_WITHIN_RANGE
from tissue_probe.physics.effects.backlash import BACKLASH
from tissue_probe.physics.effects.bilinear_spring import BILINEAR_SPRING
from tissue_probe.physics.effects.bouc_wen_hysteresis import BOUC_WEN_HYSTERESIS
from tissue_probe.physics.effects.channel_delay import CHANNEL_DELAY
from tissue_probe.physics.effects.contact_loss import CONTACT_LOSS
from tissue_probe.physics.effects.coulomb_friction import COULOMB_FRICTION
from tissue_probe.physics.effects.cubic_stiffening import CUBIC_STIFFENING
from tissue_probe.physics.effects.damage_by_depth import DAMAGE_BY_DEPTH
from tissue_probe.physics.effects.effect import Effect, Parameter, State, Switch
from tissue_probe.physics.effects.encoder_interpolation import ENCODER_INTERPOLATION
from tissue_probe.physics.effects.encoder_quantization import ENCODER_QUANTIZATION
from tissue_probe.physics.effects.exponential_stiffening import EXPONENTIAL_STIFFENING
from tissue_probe.physics.effects.force_bias import FORCE_BIAS
from tissue_probe.physics.effects.force_drift import FORCE_DRIFT
from tissue_probe.physics.effects.force_gain import FORCE_GAIN
from tissue_probe.physics.effects.force_lag import FORCE_LAG
from tissue_probe.physics.effects.generalized_maxwell import GENERALIZED_MAXWELL
from tissue_probe.physics.effects.hertz_contact import HERTZ_CONTACT
from tissue_probe.physics.effects.hunt_crossley import HUNT_CROSSLEY
from tissue_probe.physics.effects.load_cell_stiffness_error import LOAD_CELL_STIFFNESS_ERROR
from tissue_probe.physics.effects.mains_hum import MAINS_HUM
from tissue_probe.physics.effects.nonlinear_damping import NONLINEAR_DAMPING
from tissue_probe.physics.effects.poroelastic_relaxation import POROELASTIC_RELAXATION
from tissue_probe.physics.effects.prandtl_ishlinskii import PRANDTL_ISHLINSKII
from tissue_probe.physics.effects.preconditioning import PRECONDITIONING
from tissue_probe.physics.effects.quasi_linear_relaxation import QUASI_LINEAR_RELAXATION
from tissue_probe.physics.effects.saturating_spring import SATURATING_SPRING
from tissue_probe.physics.effects.second_input import SECOND_INPUT
from tissue_probe.physics.effects.springpot import SPRINGPOT
from tissue_probe.physics.effects.standard_linear_solid import STANDARD_LINEAR_SOLID
from tissue_probe.physics.effects.stiffness_ramp import STIFFNESS_RAMP
from tissue_probe.physics.effects.stiffness_step import STIFFNESS_STEP
from tissue_probe.physics.effects.stribeck_friction import STRIBECK_FRICTION
from tissue_probe.physics.effects.structural_mode import STRUCTURAL_MODE
from tissue_probe.physics.effects.tissue_motion import TISSUE_MOTION
from tissue_probe.physics.effects.zero_by_part import ZERO_BY_PART
from tissue_probe.physics.extent import Extent

__all__ = ["EFFECTS", "Effect", "Extent", "Parameter", "State", "Switch"]

EFFECTS = {
    effect.name: effect
    for effect in (
        STANDARD_LINEAR_SOLID,
        GENERALIZED_MAXWELL,
        SPRINGPOT,
        QUASI_LINEAR_RELAXATION,
        POROELASTIC_RELAXATION,
        CUBIC_STIFFENING,
        EXPONENTIAL_STIFFENING,
        HERTZ_CONTACT,
        SATURATING_SPRING,
        BILINEAR_SPRING,
        DAMAGE_BY_DEPTH,
        PRECONDITIONING,
        HUNT_CROSSLEY,
        NONLINEAR_DAMPING,
        CONTACT_LOSS,
        ADHESION,
        ADHESION_WITHIN_RANGE,
        COULOMB_FRICTION,
        STRIBECK_FRICTION,
        BOUC_WEN_HYSTERESIS,
        PRANDTL_ISHLINSKII,
        BACKLASH,
        ADDED_MASS,
        STRUCTURAL_MODE,
        FORCE_GAIN,
        LOAD_CELL_STIFFNESS_ERROR,
        FORCE_BIAS,
        FORCE_DRIFT,
        ZERO_BY_PART,
        SECOND_INPUT,
        TISSUE_MOTION,
        MAINS_HUM,
        FORCE_LAG,
        CHANNEL_DELAY,
        ENCODER_QUANTIZATION,
        ENCODER_INTERPOLATION,
        STIFFNESS_STEP,
        STIFFNESS_RAMP,
    )
}
