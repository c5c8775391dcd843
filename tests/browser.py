"""A headless Chromium for tests, spoken to through the pipe of its DevTools protocol: no package, no port, no driver."""

import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")

FLAGS = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
    "--no-default-browser-check",
    "--hide-scrollbars",
    "--remote-debugging-pipe",
]

FAR_FD = 30
"""The pipe's ends are moved here first, out of the way of 3 and 4, where Chromium looks for them."""


def find() -> str | None:
    """Path of a Chromium, or None."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Browser:
    """A running Chromium that can reach no network."""

    def __init__(self, program: str, profile: Path) -> None:
        self._replies: dict[int, dict[str, Any]] = {}
        self._buffer = b""
        self._last = 0
        self.events: list[dict[str, Any]] = []
        to_read, self._write = os.pipe()
        self._read, to_write = os.pipe()
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD, FAR_FD) for fd in (to_read, to_write)]
        os.close(to_read)
        os.close(to_write)

        def place() -> None:
            os.dup2(ends[0], 3)
            os.dup2(ends[1], 4)

        self._process = subprocess.Popen(
            [program, *FLAGS, "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={profile}", "about:blank"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            preexec_fn=place,
            pass_fds=(3, 4),
        )
        for fd in ends:
            os.close(fd)

    def call(self, method: str, session: str | None = None, wait_s: float = 60, **params: Any) -> dict[str, Any]:
        """Send a command and wait for its result."""
        self._last += 1
        message = {"id": self._last, "method": method, "params": params} | ({"sessionId": session} if session else {})
        os.write(self._write, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + wait_s
        while self._last not in self._replies:
            self._receive(until)
        reply = self._replies.pop(self._last)
        if "error" in reply:
            raise RuntimeError(f"{method}: {reply['error']}")
        return reply["result"]

    def _receive(self, until: float) -> None:
        ready, _, _ = select.select([self._read], [], [], max(0.0, until - time.monotonic()))
        if not ready:
            raise TimeoutError("the browser does not answer")
        piece = os.read(self._read, 1 << 20)
        if not piece:
            raise RuntimeError("the browser has ended")
        *whole, self._buffer = (self._buffer + piece).split(b"\0")
        for text in whole:
            message = json.loads(text)
            if "id" in message:
                self._replies[message["id"]] = message
            else:
                self.events.append(message)

    def close(self) -> None:
        os.close(self._write)
        os.close(self._read)
        try:
            self._process.wait(10)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


class Page:
    """A tab of the browser, of a given size in CSS pixels."""

    def __init__(self, browser: Browser, width: int = 1200, height: int = 900, *, dark: bool = False, phone: bool = False) -> None:
        self.browser = browser
        self.target = browser.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = browser.call("Target.attachToTarget", targetId=self.target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=phone)
        self.call("Emulation.setTouchEmulationEnabled", enabled=phone)
        scheme = "dark" if dark else "light"
        self.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        return self.browser.call(method, self.session, **params)

    def open(self, path: Path, wait_s: float = 60) -> None:
        """Load a file and wait until the page says that all is drawn."""
        self.call("Page.navigate", url=path.as_uri())
        self.until("document.body && document.body.dataset.ready", wait_s)

    def until(self, expression: str, wait_s: float = 30) -> Any:
        """Wait until an expression of the page is true; returns it."""
        end = time.monotonic() + wait_s
        while not (value := self.run(expression)):
            if time.monotonic() > end:
                raise TimeoutError(f"{expression} has not become true; errors of the page: {self.problems()}")
            time.sleep(0.05)
        return value

    def run(self, expression: str) -> Any:
        """Value of an expression of the page."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(str(result["exceptionDetails"]))
        return result["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Press, move in steps, release."""
        self.mouse("mouseMoved", *start)
        self.mouse("mousePressed", *start, button="left", clickCount=1)
        for k in range(1, 6):
            w = k / 5
            self.mouse("mouseMoved", start[0] + w * (end[0] - start[0]), start[1] + w * (end[1] - start[1]), button="left", buttons=1)
        self.mouse("mouseReleased", *end, button="left", clickCount=1)

    def requests(self) -> list[str]:
        """Addresses that the page asked for."""
        mine = self._mine("Network.requestWillBeSent")
        return [event["params"]["request"]["url"] for event in mine]

    def problems(self) -> list[str]:
        """Console errors and warnings, exceptions, and what the page itself noted."""
        console = [e["params"] for e in self._mine("Runtime.consoleAPICalled") if e["params"]["type"] in ("error", "warning")]
        log = [e["params"]["entry"]["text"] for e in self._mine("Log.entryAdded") if e["params"]["entry"]["level"] in ("error", "warning")]
        thrown = [str(e["params"]["exceptionDetails"]) for e in self._mine("Runtime.exceptionThrown")]
        noted = self.run("document.documentElement.dataset.errors")
        return [str(c["args"]) for c in console] + log + thrown + ([noted] if noted else [])

    def _mine(self, method: str) -> list[dict[str, Any]]:
        return [e for e in self.browser.events if e["method"] == method and e.get("sessionId") == self.session]

    def screenshot(self, path: Path, *, whole: bool = False) -> None:
        import base64

        data = self.call("Page.captureScreenshot", captureBeyondViewport=whole)["data"]
        path.write_bytes(base64.b64decode(data))

    def close(self) -> None:
        self.browser.call("Target.closeTarget", targetId=self.target)
