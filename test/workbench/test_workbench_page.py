"""Each thing that a user does on the page, in a browser, without a network."""

from __future__ import annotations

import random
import re
import subprocess
import sys
import time

import numpy as np
import pytest

from served import EXAMPLES, PATIENCE, serving

SMALL = re.compile(r"([\d.]+) (mN|N|µm)")


def force(text: str) -> float:
    """Return the first force in a text [N]."""
    value, unit = SMALL.search(text).groups()
    return float(value) * {"mN": 1e-3, "N": 1.0, "µm": 1e-6}[unit]


def errors(page) -> list[float]:
    return [force(each.inner_text()) for each in page.locator(".rung .error").all()]


def until(page, condition: str) -> None:
    """Wait for a condition on the page, which lets no text be run as a program."""
    end = time.monotonic() + PATIENCE / 1000
    while not page.evaluate(condition):
        assert time.monotonic() < end, condition
        page.wait_for_timeout(40)


def rungs(page, count: int) -> None:
    until(page, f"document.querySelectorAll('.rung').length === {count}")


def idle(page) -> None:
    """Wait until nothing is under way."""
    until(page, "!document.querySelector('#status progress')")


def drag(page, plot, begin: float, end: float) -> None:
    """Brush a part of a plot."""
    box = page.locator(f"{plot} .u-over").first.bounding_box()
    y = box["y"] + box["height"] / 3
    page.mouse.move(box["x"] + begin * box["width"], y)
    page.mouse.down()
    page.mouse.move(box["x"] + end * box["width"], y + 5, steps=5)
    page.mouse.up()


@pytest.fixture(scope="module")
def examples(tmp_path_factory):
    """A server with the two recordings of the sweep."""
    files = (EXAMPLES / "sweep.csv", EXAMPLES / "sweep_second.csv")
    layout = ("--force-polarity", "compression", "--rig", "compliant_probe")
    with serving(tmp_path_factory.mktemp("state"), *files, *layout) as found:
        yield found


@pytest.fixture
def page(examples, open_page):
    found = open_page(examples.address)
    rungs_there(found)
    return found


def rungs_there(page) -> None:
    page.wait_for_selector(".rung")
    idle(page)


def test_the_model_is_compared_and_its_failure_told(page):
    # The rung is there before the second recording has been tried.
    until(page, "document.querySelector('.rung').innerText.includes('second')")
    page.wait_for_selector(".marks .foremost")
    assert page.inner_text(".marks .foremost").startswith("Here: time")
    assert page.locator(".parameter").count() >= 5
    for name in ("Measured and predicted", "Residual over time", "Residual over speed"):
        assert page.locator(f"[role=img][aria-label^='{name}']").count() == 1


def test_brushing_one_plot_marks_the_same_samples_in_all(page):
    drag(page, ".four .plot:nth-child(2)", 0.6, 0.9)
    until(page, "document.body.innerText.includes('brushed, rms')")
    drag(page, ".four .plot:nth-child(1)", 0.4, 0.8)
    until(page, "!document.querySelector('.column .tiny').hidden")
    page.keyboard.press("Escape")
    until(page, "!document.body.innerText.includes('brushed, rms')")


def test_a_slider_moves_the_prediction_and_fit_puts_it_back(page):
    before = page.inner_text(".figures dd >> nth=0")
    page.focus("[data-parameter=stiffness] input[type=range]")
    for _ in range(5):
        page.keyboard.press("PageUp")
    page.wait_for_selector(".figures dd.bad")
    assert force(page.inner_text(".figures dd >> nth=0")) > force(before)
    page.fill("[data-parameter=damping] input[type=text]", "-3")
    page.keyboard.press("Enter")
    page.wait_for_selector("#told >> text=it lies from 0")
    page.keyboard.press("Tab")
    page.click("text=Fit")
    until(page, f"document.querySelector('.figures dd').innerText === '{before}'")


def test_the_wheel_zooms_and_a_double_click_shows_all(page):
    over = page.locator(".column .plot >> nth=0").locator(".u-over")
    over.hover()
    for _ in range(4):
        page.mouse.wheel(0, -100)
    page.wait_for_selector("text=Whole record")
    over.dblclick()
    page.wait_for_selector("text=Whole record", state="hidden")


def test_what_is_missing_is_ranked_added_undone_and_shown_side_by_side(page, tmp_path):
    page.keyboard.press("r")
    page.wait_for_selector(".ranking tbody tr")
    page.keyboard.press("ArrowDown")
    page.wait_for_selector("text=would take off")
    assert page.locator(".verdict").count() == 0, "a curve is shown while others are computed"
    page.wait_for_selector(".verdict")
    assert "hertz_contact" in page.inner_text(".verdict")
    assert page.locator(".ranking tbody tr").first.get_attribute("data-effect") == "hertz_contact"
    page.evaluate("import('/app.js').then((app) => app.explain('hertz_contact'))")
    page.wait_for_selector("text=hertz_contact would take off")
    page.keyboard.press("a")
    rungs(page, 2)
    idle(page)
    before, after = errors(page)
    assert after < before / 5
    page.select_option("select[aria-label='Beside it']", label="beside: Kelvin-Voigt")
    page.wait_for_selector(".charts.two")
    page.select_option("select[aria-label='Beside it']", "second")
    page.wait_for_selector("text=nothing fitted")
    page.select_option("select[aria-label='Beside it']", "")
    page.keyboard.press("u")
    rungs(page, 1)
    page.dblclick("[data-add] >> nth=1")
    rungs(page, 2)
    idle(page)
    rungs(page, 2)
    page.click("[data-replace=hertz_contact]")
    idle(page)
    last = "[...document.querySelectorAll('.rung')].at(-1).innerText"
    until(page, f"{last}.includes('hertz_contact')")
    rungs(page, 2)
    page.keyboard.press("2")
    page.hover(".column .plot >> nth=0")
    with page.expect_download() as download:
        page.click(".column .plot >> nth=0 >> .save")
    download.value.save_as(tmp_path / "plot.png")
    assert (tmp_path / "plot.png").read_bytes().startswith(b"\x89PNG")
    page.hover(".column .plot >> nth=0 >> .u-over")
    until(page, "document.querySelector('.column .readout').innerText.includes('measured')")
    assert "predicted" in page.inner_text(".column .readout >> nth=0")
    page.keyboard.press("4")
    page.wait_for_selector("text=The next experiment")
    page.keyboard.press("6")
    for name, begins in (
        ("model.yaml", b"version: 1"), ("steps.ipynb", b"{"), ("desk.workbench", b"PK"),
        ("report.html", b"<!"),
    ):  # fmt: skip
        with page.expect_download() as download:
            page.click(f"[data-take='{name}']")
        path = tmp_path / name
        download.value.save_as(path)
        assert path.read_bytes().lstrip().startswith(begins)
    page.keyboard.press("1")
    page.set_input_files("input.files", tmp_path / "desk.workbench")
    until(page, "document.querySelectorAll('.rung').length === 2")
    idle(page)
    page.keyboard.press("u")
    rungs(page, 1)


def test_a_search_is_cancelled_by_escape(page):
    page.keyboard.press("r")
    page.wait_for_selector("text=Cancel")
    page.keyboard.press("Escape")
    idle(page)
    rungs(page, 1)


def test_effects_typed_run_after_consent_only(page):
    page.keyboard.press("3")
    page.click("text=Effects of your own")
    page.click("text=Check and take")
    page.wait_for_selector(".wrong[data-field=consent]")
    page.check("[data-field=consent] input")
    page.fill("textarea.code", "import nothing_of_that_name")
    page.click("text=Check and take")
    page.wait_for_selector("text=cannot be run")


def test_two_pages_show_one_desk(examples, page, open_page):
    other = open_page(examples.address, color_scheme="dark")
    rungs_there(other)
    page.keyboard.press("3")
    page.wait_for_selector("[data-key=rank]")
    other.evaluate("import('/app.js').then((app) => app.act('add', { effect: 'force_bias' }))")
    rungs(page, 2)
    rungs(other, 2)
    idle(page)
    page.keyboard.press("u")
    rungs(other, 1)


def test_a_file_that_does_not_tell_all_is_asked_about(server, open_page):
    page = open_page(server.address)  # beside another file it would take what that was told
    page.click("[data-example=machine]")
    page.wait_for_selector(".wrong[data-field=force_polarity]")
    assert "state force polarity" in page.inner_text(".problem >> nth=0")
    assert page.locator(".tablewrap canvas").count() == 3
    page.select_option("select[name=force_polarity]", "tension")
    page.click("button:text('Read')")
    until(page, "!document.querySelector('.tablewrap')")
    page.keyboard.press("1")
    page.locator("article", has_text="testing_machine").locator("[aria-label^=Take]").click()
    until(page, "!document.body.innerText.includes('testing_machine')")


def test_a_file_is_dropped_or_refused(page, tmp_path):
    page.keyboard.press("1")
    bad = tmp_path / "words.csv"
    bad.write_text("no,numbers\n")
    page.set_input_files("input.files", bad)
    page.wait_for_selector("article >> text=words.csv has")
    page.evaluate(
        """() => {
          const file = new File([[...Array(300).keys()].map(
            (n) => n ? `${n / 500},${Math.sin(n / 9) / 1000},${Math.sin(n / 9) / 2}` : "t,u,F",
          ).join("\\n")], "dropped.csv");
          const dataTransfer = new DataTransfer();
          dataTransfer.items.add(file);
          dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true, cancelable: true }));
        }"""
    )
    page.wait_for_selector("article:has-text('dropped.csv') >> text=samples")
    for name in ("words.csv", "dropped.csv"):
        page.locator("article", has_text=name).locator("[aria-label^=Take]").click()
        page.wait_for_selector(f"article:has-text('{name}')", state="detached")


def test_a_scan_is_mapped_and_a_site_opens_its_recording(page):
    page.keyboard.press("1")
    page.click("[data-example=scan]")
    page.wait_for_selector(".map image")
    assert page.locator(".map .site").count() == 16
    layers = page.locator("[data-layer]")
    assert layers.count() == 4
    for number in range(4):
        layers.nth(number).click()
        pressed = f"document.querySelectorAll('[data-layer]')[{number}].ariaPressed === 'true'"
        until(page, pressed)
    page.hover(".map image", position={"x": 200, "y": 200})
    page.wait_for_selector(".readout >> text=P(inclusion)")
    page.click(".map .site[data-site='5']")
    rungs(page, 1)
    idle(page)
    page.wait_for_selector("text=scan.mcap")


def test_the_rig_is_asked_first_and_a_refusal_fills_the_stage(open_page, tmp_path):
    still = tmp_path / "still.csv"
    rows = [f"{n / 500},{1e-3 + (n % 7) * 1e-12},{(n % 5) / 2}" for n in range(300)]
    still.write_text("\n".join(["t,u,F", *rows]) + "\n")
    with serving(tmp_path, still, "--force-polarity", "compression") as server:
        page = open_page(server.address)
        page.wait_for_selector("[data-rig]")
        assert page.locator("[data-rig] svg").count() == 3
        assert "a testing machine" in page.inner_text("[data-rig=rigid_probe]")
        page.click("[data-rig=rigid_probe]")
        page.wait_for_selector("[data-stopped=refusal]")
        told = page.inner_text("[data-stopped=refusal]")
        assert "still.csv cannot be fitted as it is" in told
        assert str(tmp_path) not in page.content()
        page.click("text=Remove the recording")
        page.wait_for_selector("[data-stopped]", state="detached")
        page.close()


def test_a_second_input_is_named_by_its_column_and_found_missing(open_page, tmp_path):
    time_s = np.arange(2000) / 500
    depth = 1e-3 * np.sin(2 * np.pi * 3.0 * time_s) * np.sin(2 * np.pi * 0.37 * time_s)
    speed = np.gradient(depth, time_s)
    pressure = np.sin(2 * np.pi * 1.3 * time_s) + 0.5 * np.sin(2 * np.pi * 4.1 * time_s + 1.0)
    noise = 2e-3 * np.random.default_rng(0).standard_normal(time_s.size)
    force_n = 400.0 * depth + 3.0 * speed + 0.1 * pressure + noise
    table = np.column_stack([time_s, depth, force_n, pressure])
    recorded = tmp_path / "pressed.csv"
    header = "time_s,position_m,force_N,pressure"
    np.savetxt(recorded, table, delimiter=",", header=header, comments="")
    layout = ("--force-polarity", "compression", "--rig", "rigid_probe")
    with serving(tmp_path, recorded, *layout) as server:
        page = open_page(server.address)
        rungs_there(page)
        page.keyboard.press("1")
        card = page.locator("article", has_text="pressed.csv")
        card.locator("summary", has_text="A second input").click()
        card.locator("[name=input2]").fill("presure")
        card.locator("text=Read anew").click()
        page.wait_for_selector("article >> text=presure")
        card.locator("[name=input2]").select_option("pressure")
        card.locator("button", has_text="Read").click()
        rungs_there(page)
        page.keyboard.press("r")
        page.wait_for_selector(".verdict")
        assert "second_input" in page.inner_text(".verdict")
        page.close()


def test_the_shape_of_a_force_that_no_law_explains_is_drawn(open_page, tmp_path):
    rate = 1000.0
    time_s = np.arange(3000) / rate
    random_start = np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, 12)
    angle = np.multiply.outer(time_s, 2.0 * np.pi * np.linspace(1.0, 23.0, 12)) + random_start
    depth = 3e-4 * np.sin(angle).sum(axis=1)
    noise = 5e-3 * np.random.default_rng(1).standard_normal(time_s.size)
    wavy = 0.05 * np.sin(depth / 2e-4)
    force_n = 400.0 * depth + 4.0 * rate * np.gradient(depth) + wavy + noise
    recorded = tmp_path / "wavy.csv"
    header = "time_s,position_m,force_N"
    table = np.column_stack([time_s, depth, force_n])
    np.savetxt(recorded, table, delimiter=",", header=header, comments="")
    rig = ("--rig", "rigid_probe", "--constant", "tip_mass=0", "--starts", "moving")
    with serving(tmp_path, recorded, "--force-polarity", "compression", *rig) as server:
        page = open_page(server.address)
        rungs_there(page)
        page.keyboard.press("r")
        page.wait_for_selector("img.shape")
        assert page.evaluate("document.querySelector('img.shape').naturalWidth") > 100
        assert "a function of the indentation" in page.inner_text(".verdict")
        page.close()


def test_on_a_telephone_nothing_is_cut_small_or_out_of_reach(examples, open_page):
    page = open_page(examples.address, (390, 844))
    rungs_there(page)
    for stage in "23":
        page.keyboard.press(stage)
        page.wait_for_timeout(300)
        wide = page.evaluate(
            "Math.max(document.documentElement.scrollWidth, "
            "document.querySelector('#stage').scrollWidth) - innerWidth"
        )
        assert wide <= 0, f"stage {stage} is {wide} pixels too wide"
        small = page.evaluate(
            """() => [...document.querySelectorAll("#stage *, .bar *, .rail *")]
              .filter((each) => each.getClientRects().length && !each.closest(".skip"))
              .filter((each) => [...each.childNodes].some((one) => one.data?.trim()))
              .filter((each) => parseFloat(getComputedStyle(each).fontSize) < 12)
              .map((each) => each.outerHTML)"""
        )
        assert small == []
        off = page.evaluate(
            """() => [...document.querySelectorAll("button, select, input")]
              .filter((each) => each.getClientRects().length)
              .filter((each) => !each.closest(".rail, .ladder"))
              .filter((each) => each.getBoundingClientRect().right > innerWidth + 1)
              .map((each) => each.outerHTML)"""
        )
        assert off == []


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (3840, 2160)])
def test_nothing_is_cut_off_and_everything_has_a_name(examples, open_page, size):
    page = open_page(examples.address, size)
    rungs_there(page)
    for stage in "123456":
        page.keyboard.press(stage)
        page.wait_for_timeout(100)
        wide = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        assert wide <= 0, f"stage {stage} is {wide} pixels too wide"
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, input, select, textarea, [role=img]")]
          .filter((each) => !each.matches("[hidden], .u-hidden"))
          .filter((each) => !(each.innerText || each.ariaLabel || each.title ||
                              each.labels?.length)).map((each) => each.outerHTML)"""
    )
    assert unnamed == []


def test_a_hundred_random_clicks_and_keys_do_no_harm(examples, open_page):
    page = open_page(examples.address)
    rungs_there(page)
    chance = random.Random(7)
    for _ in range(100):
        if chance.random() < 0.35:
            page.keyboard.press(chance.choice([*"123456fut?", "Escape", "ArrowDown", "Tab"]))
            continue
        x, y = chance.uniform(0, 1280), chance.uniform(0, 720)
        if chance.random() < 0.3:
            page.mouse.move(x, y)
            page.mouse.down()
            page.mouse.move(chance.uniform(0, 1280), y + 20, steps=2)
            page.mouse.up()
        else:
            page.mouse.click(x, y)
    page.keyboard.press("Escape")
    page.reload()
    page.wait_for_selector("#rail button")
    until(page, "document.querySelector('#stage').children.length > 0")


def test_a_server_that_is_killed_and_started_again_goes_on(open_page, tmp_path):
    layout = ("--force-polarity", "compression", "--rig", "compliant_probe")
    with serving(tmp_path, EXAMPLES / "sweep.csv", *layout) as first:
        page = open_page(first.address)
        rungs_there(page)
        page.evaluate("import('/app.js').then((app) => app.act('add', { effect: 'force_bias' }))")
        rungs(page, 2)
        idle(page)
        first.kill()
        page.wait_for_selector("text=The server is gone")
        with serving(tmp_path, port=first.port) as again:
            assert again.token == first.token
            page.wait_for_selector("text=The server is gone", state="hidden")
            rungs(page, 2)
            idle(page)
            page.close()
    # That a server does not answer is an error that the browser itself writes down.
    gone = [each for each in open_page.complaints if "ERR_CONNECTION_REFUSED" in each]
    for each in gone:
        open_page.complaints.remove(each)


def test_without_its_packages_the_command_says_what_to_install(tmp_path):
    code = "import sys; sys.modules['uvicorn'] = None; from tissue_probe.cli import main; main()"
    command = [sys.executable, "-c", code, "workbench", "--no-browser"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    assert "pip install 'tissue_probe[workbench]'" in done.stderr
