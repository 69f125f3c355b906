"""The page of `sphecs watch --serve` in a headless browser, beside a run under way."""

import contextlib
import shutil
import socket
import subprocess
import time

import pytest
from conftest import ROOT, binary

BROWSERS = ("chromium-headless-shell", "chromium", "google-chrome")


@pytest.fixture(scope="module")
def browser():
    """A browser without a window; without one on the machine the tests are skipped."""
    sync_api = pytest.importorskip("playwright.sync_api")
    path = next(filter(None, map(shutil.which, BROWSERS)), None)
    if path is None:
        pytest.skip(f"none of {', '.join(BROWSERS)} is installed")
    with sync_api.sync_playwright() as playwright:
        # The sandbox of the browser needs rights that a container lacks. The page is our own.
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


@contextlib.contextmanager
def started(*arguments):
    """Starts the program and ends it afterwards."""
    command = [binary(), *map(str, arguments)]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.terminate()
        process.wait(timeout=30)


@contextlib.contextmanager
def page_of(browser, run):
    """Opens the page of a run; errors of its script and of its requests are collected."""
    port = free_port()
    page = browser.new_page()
    with started("watch", run, "--serve", port):
        deadline = time.monotonic() + 30
        while True:
            try:
                page.goto(f"http://127.0.0.1:{port}/")
                break
            except Exception:
                assert time.monotonic() < deadline, "the page is not served"
                time.sleep(0.1)
        errors = []
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.on("requestfailed", lambda request: errors.append(request.url))
        page.on("response", lambda answer: answer.ok or errors.append(f"{answer.status} {answer.url}"))
        yield page, errors


def wait_for(page, condition):
    page.wait_for_function(condition, timeout=60_000)


PICTURE_IS_DRAWN = "() => { const p = document.getElementById('picture'); return p.complete && p.naturalWidth > 100; }"
FIGURE = """name => [...document.querySelectorAll('#figures div')]
    .find(one => one.children[0].textContent === name).children[1].textContent"""


def test_page_follows_a_run_under_way(browser, tmp_path):
    run = tmp_path / "run"
    with started(
        "run", "scenes/quickstart.ron", "--smoke", "--set", "time.end=200.0", "--set", "output.every=0.1",
        "--set", "output.probes=[]", "--set", "output.fields=()", "--out", run, "--quiet",
    ):
        deadline = time.monotonic() + 60
        while not (run / "summary.json").exists():
            assert time.monotonic() < deadline, "the run does not start"
            time.sleep(0.1)
        with page_of(browser, run) as (page, errors):
            wait_for(page, "() => document.querySelectorAll('#curves polyline').length >= 4")
            wait_for(page, PICTURE_IS_DRAWN)
            assert "running" in page.text_content("#said")
            assert page.text_content("#title") in page.title()
            first = page.evaluate(FIGURE, "steps")
            frames = page.evaluate(FIGURE, "frames")
            # The figures and the picture follow without a reload.
            page.wait_for_function(f"first => ({FIGURE})('steps') !== first", arg=first, timeout=60_000)
            page.wait_for_function(
                "frames => !document.getElementById('picture').src.endsWith(`frames=${frames}`)",
                arg=frames, timeout=60_000,
            )
            wait_for(page, PICTURE_IS_DRAWN)
            assert errors == []


def test_page_of_a_complete_run_draws_the_chosen_field(browser, run_folder):
    with page_of(browser, run_folder) as (page, errors):
        wait_for(page, PICTURE_IS_DRAWN)
        assert "completed" in page.text_content("#said")
        for field in ("pressure", "vorticity", "density", "zone"):
            page.select_option("#field", field)
            page.wait_for_function(
                "field => document.getElementById('picture').src.includes(`field=${field}`)", arg=field, timeout=60_000,
            )
            wait_for(page, PICTURE_IS_DRAWN)
        values = page.evaluate("() => [...document.querySelectorAll('#figures b')].map(one => one.textContent)")
        assert len(values) >= 10
        assert all("NaN" not in value and "undefined" not in value for value in values), values
        # The curves lie within their frame.
        points = page.evaluate("() => [...document.querySelectorAll('polyline')].flatMap(one => [...one.points].map(p => [p.x, p.y]))")
        assert points and all(0 <= x <= 300 and 0 <= y <= 100 for x, y in points)
        assert errors == []


def test_page_says_that_the_server_is_gone(browser, run_folder):
    with page_of(browser, run_folder) as (page, _):
        wait_for(page, PICTURE_IS_DRAWN)
    wait_for(page, "() => document.getElementById('said').classList.contains('error')")
    assert "no answer" in page.text_content("#said")
