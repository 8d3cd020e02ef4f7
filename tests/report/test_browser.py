"""The page in a real browser, from a file: no errors, and everything that can be pressed works."""

import base64
import json
import shutil
from collections.abc import Iterator

import pytest

_WHY = "needs the extra `browser` (selenium)"
webdriver = pytest.importorskip("selenium.webdriver", reason=_WHY)
By = pytest.importorskip("selenium.webdriver.common.by", reason=_WHY).By
Keys = pytest.importorskip("selenium.webdriver.common.keys", reason=_WHY).Keys
WebDriverWait = pytest.importorskip("selenium.webdriver.support.ui", reason=_WHY).WebDriverWait

_CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
_DRIVER = shutil.which("chromedriver")

pytestmark = [
    pytest.mark.skipif(not _CHROMIUM, reason="no chromium: apt-get install chromium"),
    pytest.mark.skipif(not _DRIVER, reason="no chromedriver: apt-get install chromium-driver"),
    # Selenium leaves the driver's pipes to the garbage collector.
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]

FLAGS = (
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-background-networking",
    "--disable-dev-shm-usage", "--window-size=1200,900",
)  # fmt: skip


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator:
    options = webdriver.ChromeOptions()
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"):
        options.add_argument(flag)
    options.binary_location = str(_CHROMIUM)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(_DRIVER))
    yield driver
    driver.quit()


@pytest.fixture
def page(browser, solid):
    """The page, freshly loaded."""
    for log in ("browser", "performance"):
        browser.get_log(log)
    browser.get(solid.report.as_uri())
    return browser


def column(page, table: str, name: str) -> list[str]:
    """The texts of a column of the first table within `table`, top to bottom."""
    heads = [h.text.split("\n")[0] for h in page.find_elements(By.CSS_SELECTOR, f"{table} thead th")]
    index = next(i for i, head in enumerate(heads) if head.startswith(name))
    return [c.text for c in page.find_elements(By.CSS_SELECTOR, f"{table} tbody td:nth-child({index + 1})")]


def button(page, table: str, name: str):
    found = page.find_elements(By.CSS_SELECTOR, f"{table} thead button")
    return next(b for b in found if b.text.startswith(name))


JUDGED = "#table-e table.sortable"


def test_the_page_loads_without_errors_and_without_the_network(page, solid):
    assert page.get_log("browser") == []
    assert solid.config.name in page.title
    events = [json.loads(entry["message"])["message"] for entry in page.get_log("performance")]
    sent = [e["params"] for e in events if e["method"] == "Network.requestWillBeSent"]
    asked = [s["request"]["url"] for s in sent if s["documentURL"] == solid.report.as_uri()]
    assert solid.report.as_uri() in asked
    assert [url for url in asked[1:] if not url.startswith("data:")] == []


def test_a_click_sorts_a_column_and_another_turns_it(page):
    numbers = column(page, JUDGED, "numbers")
    button(page, JUDGED, "numbers").click()
    rising = column(page, JUDGED, "numbers")
    assert rising == sorted(numbers, key=int) != numbers[::-1]
    button(page, JUDGED, "numbers").click()
    assert column(page, JUDGED, "numbers") == rising[::-1]
    heads = page.find_elements(By.CSS_SELECTOR, f"{JUDGED} th[aria-sort]")
    assert [h.get_attribute("aria-sort") for h in heads] == ["descending"]


def test_numbers_sort_by_value_and_what_is_unknown_stays_last(page):
    """As texts 1.0e+01 and 9.0e-02 would sort otherwise; a look-up table has no operations."""
    for _ in range(2):
        button(page, JUDGED, "operations").click()
        assert column(page, JUDGED, "operations")[-1] == "–"
    button(page, JUDGED, "RMSE").click()
    errors = [float(t) for t in column(page, JUDGED, "RMSE")]
    assert errors == sorted(errors)


def test_the_keyboard_sorts_too(page):
    head = button(page, JUDGED, "approximation")
    page.execute_script("arguments[0].focus()", head)
    page.switch_to.active_element.send_keys(Keys.ENTER)
    names = column(page, JUDGED, "approximation")
    assert names == sorted(names)


def test_the_slider_moves_the_truth_to_another_place(page, solid):
    slider = page.find_element(By.CSS_SELECTOR, "#slices-e input[type=range]")
    before = page.find_element(By.CSS_SELECTOR, "#slices-e path.truth").get_attribute("d")
    assert slider.get_attribute("aria-valuetext") == "F0 = 0.5"
    slider.send_keys(Keys.ARROW_RIGHT)
    assert slider.get_attribute("aria-valuetext") == "F0 = 0.75"
    assert page.find_element(By.CSS_SELECTOR, "#slices-e output").text == "F0 = 0.75"
    after = page.find_element(By.CSS_SELECTOR, "#slices-e path.truth").get_attribute("d")
    assert after != before
    # The table falls with F0, and a picture's y grows downwards.
    assert float(after.split()[1].split("L")[0]) > float(before.split()[1].split("L")[0])


def test_curves_pass_through_the_table(page, solid):
    """The first curve's first point is the table's entry there, read back from the picture's scale."""
    table = solid.tables["e"]
    low, high = table.values.min(), table.values.max()
    margin = 0.03 * (high - low)
    paths = page.find_elements(By.CSS_SELECTOR, "#slices-e path.truth")
    y = float(paths[0].get_attribute("d").split()[1].split("L")[0])
    found = low - margin + (1.0 - (y - 14.0) / 270.0) * (high - low + 2.0 * margin)
    assert found == pytest.approx(table.values[2, 0, 0], abs=2e-3)


def test_another_approximation_has_another_error(page):
    choice = page.find_element(By.CSS_SELECTOR, "#slices-e select")
    before = page.find_element(By.CSS_SELECTOR, "#slices-e path.error").get_attribute("d")
    options = choice.find_elements(By.TAG_NAME, "option")
    other = next(o for o in options if not o.is_selected())
    other.click()
    assert page.find_element(By.CSS_SELECTOR, "#slices-e path.error").get_attribute("d") != before


def test_copy_puts_the_shown_code_on_the_clipboard(page):
    page.execute_cdp_cmd(
        "Browser.grantPermissions", {"permissions": ["clipboardReadWrite", "clipboardSanitizedWrite"]}
    )
    block = page.find_element(By.CSS_SELECTOR, "details.code")
    block.find_element(By.TAG_NAME, "summary").click()
    language = block.find_element(By.TAG_NAME, "select")
    language.find_element(By.CSS_SELECTOR, "option[value=json]").click()
    shown = [p for p in block.find_elements(By.TAG_NAME, "pre") if p.is_displayed()]
    assert [p.get_attribute("data-language") for p in shown] == ["json"]
    copy = block.find_element(By.CSS_SELECTOR, "button.copy")
    copy.send_keys(Keys.ENTER)
    WebDriverWait(page, 5).until(lambda _: copy.text == "Copied")
    page.execute_script(
        "const a = document.createElement('textarea'); a.id = 'paste'; document.body.append(a)"
    )
    area = page.find_element(By.ID, "paste")
    area.send_keys(Keys.CONTROL, "v")
    assert area.get_attribute("value") == shown[0].get_property("textContent")


def test_everything_to_press_is_reached_by_tab_and_named(page):
    page.execute_script("window.scrollTo(0, 0)")
    body = page.find_element(By.TAG_NAME, "body")
    seen = []
    for _ in range(60):
        body.send_keys(Keys.TAB) if not seen else page.switch_to.active_element.send_keys(Keys.TAB)
        seen.append(page.switch_to.active_element.tag_name)
    assert {"a", "button", "select", "input", "summary"} <= set(seen)
    unnamed = page.execute_script(
        "return [...document.querySelectorAll('button, input, select, svg, img')]"
        ".filter(e => !(e.textContent.trim() || e.ariaLabel || e.alt || e.labels?.length)).length"
    )
    assert unnamed == 0


def test_nothing_hangs_over_the_edge_of_a_small_screen(page):
    page.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": 390, "height": 800, "deviceScaleFactor": 1, "mobile": True},
    )
    try:
        assert page.execute_script("return document.documentElement.scrollWidth") <= 390
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_stands_out_in_both_schemes(page, scheme: str):
    """WCAG 2: 4.5 : 1 for the text and its muted, good and bad kinds, on the paper and on the soft ground."""
    page.execute_cdp_cmd(
        "Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    )
    names = ("ink", "muted", "accent", "bad", "good", "paper", "soft")
    read = "return getComputedStyle(document.documentElement).getPropertyValue(arguments[0]).trim()"
    light = {n: luminance(page.execute_script(read, f"--{n}")) for n in names}
    assert (light["paper"] > 0.5) == (scheme == "light")
    for text in names[:5]:
        for ground in names[5:]:
            bright, dark = max(light[text], light[ground]), min(light[text], light[ground])
            assert (bright + 0.05) / (dark + 0.05) >= 4.5, (scheme, text, ground)


def luminance(colour: str) -> float:
    """WCAG's relative luminance of #rrggbb."""
    parts = [int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_it_prints(page):
    pdf = base64.b64decode(page.execute_cdp_cmd("Page.printToPDF", {})["data"])
    assert pdf.startswith(b"%PDF")
