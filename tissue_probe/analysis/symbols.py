"""The letters of the field for the symbols of models, in LaTeX; words where it has none."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import sympy as sp

#: By the symbol's name in a model.
LETTERS = {
    "tip_position": "x",
    "tip_velocity": "\\dot{x}",
    "indentation": "x",
    "position": "u",
    "position_rate": "\\dot{u}",
    "position_acceleration": "\\ddot{u}",
    "force": "F",
    "stiffness": "k",
    "damping": "\\beta",
    "tip_mass": "m",
    "load_cell_stiffness": "k_0",
    "load_cell_damping": "\\beta_0",
    "contact_position": "u_0",
    "time": "t",
    "spring_extension": "x_s",
    "relaxing_stiffness": "k_1",
    "relaxation_rate": "r",
    "branch_compression": "z",
    "relaxing_stiffness_1": "k_1",
    "relaxing_stiffness_2": "k_2",
    "relaxation_rate_1": "r_1",
    "relaxation_rate_2": "r_2",
    "branch_compression_1": "z_1",
    "branch_compression_2": "z_2",
    "relaxing_stiffness_3": "k_3",
    "relaxation_rate_3": "r_3",
    "branch_compression_3": "z_3",
    "spectrum_stiffness": "k_s",
    "spectrum_slope": "s",
    "slowest_rate": "r_s",
    "fastest_rate": "r_f",
    "fluid_stiffness": "k_f",
    "diffusion_rate": "r_D",
    "springpot_stiffness": "c_\\alpha",
    "springpot_exponent": "\\alpha",
    "cubic_stiffness": "k_3",
    "exponential_force": "a",
    "exponential_length": "L",
    "contact_exponent": "n",
    "softening_with_depth": "c",
    "depth_damping": "b",
    "depth_damping_exponent": "p",
    "pull_off_force": "F_a",
    "bond_force": "P",
    "adhesion_range": "R",
    "coulomb_force": "F_c",
    "transition_velocity": "v_t",
    "stribeck_coulomb_force": "F_c",
    "breakaway_excess": "F_b",
    "stribeck_velocity": "v_s",
    "stribeck_transition_velocity": "v_t",
    "hysteretic_force": "F_h",
    "yield_displacement": "x_y",
    "elastic_displacement": "z_h",
    "hysteretic_stiffness": "k_h",
    "loop_closing": "\\beta_h",
    "loop_bending": "\\gamma_h",
    "weakening_by_work": "\\delta_h",
    "work_so_far": "e",
    "stack_force": "F_h",
    "largest_slip": "D",
    "slip_ratio": "q",
    "slip_slope": "a",
    "backlash_width": "w",
    "follower_position": "u_f",
    "added_mass": "m_a",
    "modal_mass": "m_2",
    "modal_frequency": "f_2",
    "modal_damping_ratio": "\\zeta",
    "modal_displacement": "x_2",
    "modal_velocity": "v_2",
    "gain_error": "e",
    "load_cell_stiffness_share": "e_0",
    "force_bias": "F_0",
    "force_drift": "\\dot{F}_0",
    "drift_start": "F_d",
    "drift_time": "\\tau_d",
    "motion_sine": "a_m",
    "motion_cosine": "b_m",
    "motion_frequency": "f_m",
    "hum_sine": "a_h",
    "hum_cosine": "b_h",
    "hum_frequency": "f_h",
    "lag_time": "\\tau",
    "lagged_force": "F_l",
    "channel_delay": "T",
    "encoder_step": "q",
    "interpolation_sine": "a_g",
    "interpolation_cosine": "b_g",
    "grating_period": "\\lambda",
    "step_change": "\\Delta k",
    "step_time": "t_s",
    "ramp_change": "\\Delta k",
    "ramp_begin": "t_r",
    "ramp_duration": "T_r",
}


def letter(name: str) -> str:
    """Return the letter of a symbol; else its name upright, its number as an index."""
    known = LETTERS.get(name)
    if known:
        return known
    stem, _, number = name.rpartition("_")
    if not number.isdigit():
        stem, number = name, ""
    return f"\\text{{{stem.replace('_', ' ')}}}" + (f"_{{{number}}}" if number else "")


def latex(expression: sp.Expr) -> str:
    """Set an expression with the letters of the field, and words where it has none.

    Factors have dots between them: a mere space would not part words from words.
    """
    import sympy as sp

    names = {symbol: letter(str(symbol)) for symbol in expression.free_symbols}
    return str(sp.latex(expression, symbol_names=names, mul_symbol="dot"))
