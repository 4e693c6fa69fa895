"""What is stated with a probability, beside the truth: by answers of which all is known."""

import io

from rich.console import Console

from benchmarks.ruler.probabilities import Stated, stated, table


def answer(verdict, first, *models, family=None):
    effect, probability = first
    return {
        "verdict": verdict,
        "ranking": [{"effect": effect, "probability": probability}],
        "models": [{"effects": effects, "probability": share} for effects, share in models],
        "family": family,
    }


def test_the_first_effect_is_right_where_a_right_model_has_it():
    told = answer("missing", ("a", 0.98), (["a", "b"], 0.97), (["a"], 0.03))
    assert stated(told, [["b", "a"]], ["f"]) == Stated(0.98, True, True, None, True, 1)
    assert not stated(told, [["c"]], ["f"]).right
    assert not stated(told, [], []).right


def test_the_set_is_the_fewest_models_that_have_its_probability_together():
    told = answer("ambiguous", ("a", 0.6), (["a"], 0.6), (["b"], 0.36), (["c"], 0.04), family="f")
    assert stated(told, [["b"]], ["f"]) == Stated(0.6, False, True, True, True, 2)
    assert stated(told, [["c"]], ["g"]) == Stated(0.6, False, True, False, False, 2)


def test_of_what_names_nothing_no_set_is_judged():
    told = answer("adequate", ("a", 0.01), ([], 0.99))
    assert stated(told, [["a"]], ["f"]).held is None


def test_the_table_says_how_often_each_bin_is_right_and_scores_it():
    sure = [Stated(0.99, True, True, None, True, 1)] * 3
    doubtful = [Stated(0.6, False, True, True, False, 2)]
    out = io.StringIO()
    Console(file=out, width=120).print(table("told", sure + doubtful))
    text = " ".join(out.getvalue().split())
    assert "0.97 to 1 │ 3 │ 0.990 │ 1.000" in text
    assert "0.5 to 0.7 │ 1 │ 0.600 │ 0.000" in text
    assert f"{(3 * 0.01**2 + 0.6**2) / 4:.4f}" in text
    assert "0.2500" in text  # one of four names is wrong
    assert "the set of 0.95 holds the truth │ 4 │ │ 0.750" in text
    assert "1.25" in text
