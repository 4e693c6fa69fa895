"""A wrong value is refused in one sentence: its name, what it is, what it takes, and the unit."""

from __future__ import annotations

from typing import Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, ConfigDict, model_validator

from tissue_probe.devices.limits import Limits
from tissue_probe.devices.registry import DEVICES
from tissue_probe.estimation import EstimatorSettings
from tissue_probe.settings import SettingsError, bound, build, meaning, rule, setting

ALL_SETTINGS = [Limits, EstimatorSettings, *(device.settings for device in DEVICES.values())]
NUMBERS = [
    pytest.param(model, name, id=f"{model.__name__}.{name}")
    for model in ALL_SETTINGS
    for name, field in model.model_fields.items()
    if field.annotation in (int, float)
]


class Oven(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    temperature: float = setting(180.0, "K", "how hot it is inside", gt=0.0, le=500.0)
    trays: int = setting(2, "", "trays in it", ge=1, lt=5)
    mode: Literal["fan", "grill"] = setting("fan", "", "what it does")
    light: bool = setting(False, "", "whether it is lit")
    label: str = setting("", "", "what it is called")
    dishes: tuple[str, ...] = setting((), "", "what is baked")
    door: float = setting(..., "m", "width of the door", ge=0.0)

    @model_validator(mode="after")
    def _fits(self) -> Oven:
        if self.mode == "grill" and self.trays > 1:
            raise ValueError(f"there are {self.trays} trays; give one to grill")
        return self


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"temperature": 0.0}, "oven.temperature is 0.0: give a number above 0 to 500 [K]"),
        ({"temperature": 501}, "oven.temperature is 501: give a number above 0 to 500 [K]"),
        ({"temperature": "hot"}, "oven.temperature is 'hot': give a number above 0 to 500 [K]"),
        ({"temperature": None}, "oven.temperature is None: give a number above 0 to 500 [K]"),
        ({"trays": 5}, "oven.trays is 5: give a whole number from 1 and below 5"),
        ({"trays": 1.5}, "oven.trays is 1.5: give a whole number from 1 and below 5"),
        ({"mode": "boil"}, "oven.mode is 'boil': give one of fan, grill"),
        ({"light": "dim"}, "oven.light is 'dim': give true or false"),
        ({"label": 3}, "oven.label is 3: give a text"),
        ({"dishes": 3}, "oven.dishes is 3: give a list of texts"),
        ({"door": -1.0}, "oven.door is -1.0: give a number from 0 [m]"),
        ({"mode": "grill"}, "oven.*: there are 2 trays; give one to grill"),
        (
            {"window": 1},
            "there is no oven.window; there are temperature, trays, mode, light, label, dishes, "
            "door",
        ),
    ],
)
def test_a_wrong_value_is_refused_in_one_sentence(values, said):
    with pytest.raises(SettingsError) as raised:
        build(Oven, {"door": 0.5, **values}, "oven.")
    assert str(raised.value) == said


def test_a_value_left_out_that_has_no_default_is_called_missing():
    with pytest.raises(SettingsError) as raised:
        build(Oven, {"trays": 1})
    assert str(raised.value) == "door is missing: give a number from 0 [m]"


def test_values_that_do_not_go_together_are_refused_without_a_prefix_too():
    with pytest.raises(SettingsError) as raised:
        build(Oven, {"door": 0.5, "mode": "grill"})
    assert str(raised.value) == "there are 2 trays; give one to grill"


def test_right_values_are_taken_also_as_text_and_the_rest_by_default():
    oven = build(Oven, {"door": "0.5", "temperature": " 1e2 ", "light": "true"})
    assert oven == Oven(door=0.5, temperature=100.0, light=True)
    assert (oven.trays, oven.mode) == (2, "fan")


def test_the_meaning_ends_with_the_unit_where_there_is_one():
    assert meaning(Oven.model_fields["temperature"]) == "how hot it is inside [K]"
    assert meaning(Oven.model_fields["trays"]) == "trays in it"


def test_bounds_are_told_apart():
    temperature, trays = Oven.model_fields["temperature"], Oven.model_fields["trays"]
    assert [bound(temperature, each) for each in ("gt", "ge", "lt", "le")] == [
        0.0,
        None,
        None,
        500.0,
    ]
    assert [bound(trays, each) for each in ("gt", "ge", "lt", "le")] == [None, 1, 5, None]


@pytest.mark.parametrize(("model", "name"), NUMBERS)
@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), "many", None, []])
def test_no_number_of_any_settings_takes_what_is_no_finite_number(model, name, value):
    with pytest.raises(SettingsError) as raised:
        build(model, {name: value}, "it.")
    assert str(raised.value) == f"it.{name} is {value!r}: give {rule(model.model_fields[name])}"


#: Values beside which a filter's setting may have all that its own rule allows.
WIDE = {"stiffness_minimum": -1e6, "stiffness_maximum": 1e6}
WIDE |= {"damping_minimum": -1e4, "damping_maximum": 1e4, "discretisation": "euler"}
WIDE |= {"rig": "rigid_probe"}


def beside(model, name):
    """Return the values beside which a setting has only its own rule to keep."""
    wide = WIDE if model is EstimatorSettings else {}
    return {other: value for other, value in wide.items() if other != name}


@pytest.mark.parametrize(("model", "name"), NUMBERS)
@given(data=st.data())
def test_the_rule_in_words_is_the_rule_that_is_kept(model, name, data):
    field = model.model_fields[name]
    bounds = {each: bound(field, each) for each in ("gt", "ge", "lt", "le")}
    at = data.draw(st.sampled_from([value for value in bounds.values() if value is not None]))
    value = data.draw(st.sampled_from([at - 1, at, at + 1]))
    kept = (
        (bounds["gt"] is None or value > bounds["gt"])
        and (bounds["ge"] is None or value >= bounds["ge"])
        and (bounds["lt"] is None or value < bounds["lt"])
        and (bounds["le"] is None or value <= bounds["le"])
    )
    if kept:
        assert getattr(build(model, {**beside(model, name), name: value}), name) == value
    else:
        with pytest.raises(SettingsError, match=name):
            build(model, {name: value})
