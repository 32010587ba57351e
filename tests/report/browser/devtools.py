"""Chromium by the DevTools protocol, over the pipe that it offers: nothing but python's own library."""

import base64
import fcntl
import json
import os
import re
import select
import shutil
import subprocess
import tempfile
import time

ANSWER_SECONDS = 60


def find_browser():
    """The browser's program, or None: CHROMIUM names one, else Debian's."""
    return os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")


def page_without_plotly(path):
    """The text of a report as a program built without plotly.js writes it."""
    return re.sub(r'<script id="plotly">.*?</script>', "", path.read_text(), flags=re.DOTALL)


class Browser:
    """A headless browser whose every name lookup fails, for as many pages as are wanted. Use with `with`."""

    def __init__(self, program):
        self._last_id = 0
        self._buffer = b""
        self._pages = {}  # by session
        self._profile = tempfile.TemporaryDirectory(prefix="truescatter_browser_", ignore_cleanup_errors=True)
        # The browser reads commands from descriptor 3 and answers on 4. Ours are moved out of the way first.
        ends = [fcntl.fcntl(fd, fcntl.F_DUPFD_CLOEXEC, 10) for fd in os.pipe() + os.pipe()]
        commands_out, self._commands, self._answers, answers_in = ends

        def hand_over():
            os.dup2(commands_out, 3)
            os.dup2(answers_in, 4)

        self._process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync",
             "--disable-background-networking", "--disable-component-update", "--hide-scrollbars",
             "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={self._profile.name}",
             "--remote-debugging-pipe"],
            pass_fds=(3, 4), preexec_fn=hand_over, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(commands_out)
        os.close(answers_in)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        try:
            self.call("Browser.close")
            self._process.wait(10)
        except (subprocess.TimeoutExpired, RuntimeError, OSError):
            self._process.kill()
            self._process.wait()
        os.close(self._commands)
        os.close(self._answers)
        self._profile.cleanup()

    def _receive(self):
        deadline = time.monotonic() + ANSWER_SECONDS
        while b"\0" not in self._buffer:
            if not select.select([self._answers], [], [], max(0, deadline - time.monotonic()))[0]:
                raise RuntimeError("the browser does not answer")
            piece = os.read(self._answers, 1 << 20)
            if not piece:
                raise RuntimeError("the browser has ended")
            self._buffer += piece
        message, self._buffer = self._buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, params=None, session=None):
        self._last_id += 1
        message = {"id": self._last_id, "method": method, "params": params or {}}
        if session:
            message["sessionId"] = session
        data = memoryview(json.dumps(message).encode() + b"\0")
        while data:
            data = data[os.write(self._commands, data):]
        while True:
            answer = self._receive()
            if answer.get("id") != self._last_id:
                if answer.get("sessionId") in self._pages:
                    self._pages[answer["sessionId"]].note(answer)
            elif "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']}")
            else:
                return answer["result"]

    def attach(self, page):
        """A tab for a page, with storage of its own: (storage, session)."""
        storage = self.call("Target.createBrowserContext")["browserContextId"]
        target = self.call("Target.createTarget", {"url": "about:blank", "browserContextId": storage})["targetId"]
        session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True})["sessionId"]
        self._pages[session] = page
        return storage, session

    def detach(self, storage, session):
        del self._pages[session]
        self.call("Target.disposeBrowserContext", {"browserContextId": storage})


class Page:
    """One tab of a browser, or of one of its own where a program is given. Use with `with`."""

    def __init__(self, browser, url, width=1280, height=900):
        self._own = None if isinstance(browser, Browser) else Browser(browser)
        self._browser = self._own or browser
        self.complaints = []  # exceptions, and errors of the console and of loading
        self._storage, self._session = self._browser.attach(self)
        for domain in ("Runtime", "Log", "Page"):
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride",
                  {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False})
        self.call("Page.navigate", {"url": url})
        self.wait_for("location.href !== 'about:blank' && document.readyState === 'complete'")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._browser.detach(self._storage, self._session)
        if self._own:
            self._own.__exit__()

    def note(self, event):
        """Keeps what the browser says of the page without being asked, if it is a complaint."""
        params = event.get("params", {})
        kind = event.get("method")
        if kind == "Runtime.exceptionThrown":
            details = params["exceptionDetails"]
            self.complaints.append(details.get("exception", {}).get("description", details["text"]))
        elif kind == "Runtime.consoleAPICalled" and params["type"] in ("error", "assert"):
            self.complaints.append(str(params["args"]))
        elif kind == "Log.entryAdded" and params["entry"]["level"] == "error":
            self.complaints.append(params["entry"]["text"])

    def call(self, method, params=None):
        return self._browser.call(method, params, self._session)

    def evaluate(self, expression):
        """The value of a JavaScript expression in the page; a promise's once it is there."""
        answer = self.call("Runtime.evaluate",
                           {"expression": expression, "awaitPromise": True, "returnByValue": True})
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait_for(self, expression, seconds=30):
        """The expression's first value that counts as true."""
        deadline = time.monotonic() + seconds
        while not (value := self.evaluate(expression)):
            if time.monotonic() > deadline:
                raise RuntimeError(f"this never became true: {expression}")
            time.sleep(0.05)
        return value

    def box(self, selector):
        """x, y, width and height of an element that has been scrolled into view."""
        return self.evaluate(f"""(() => {{
          const element = document.querySelector({json.dumps(selector)});
          element.scrollIntoView({{block: "center", behavior: "instant"}});
          const box = element.getBoundingClientRect();
          return [box.left, box.top, box.width, box.height];
        }})()""")

    def chart(self, selector):
        """Waits until a chart by plotly has been drawn; its box in the window."""
        self.box(selector)
        self.wait_for(f"document.querySelector({json.dumps(selector)})._fullLayout && document.querySelector("
                      f"{json.dumps(selector + ' .hoverlayer')}) !== null")
        return self.box(selector)

    def key(self, key, code="", kinds=("keyDown", "keyUp")):
        for kind in kinds:
            params = {"type": kind, "key": key, "code": code}
            if kind == "keyDown" and len(key) == 1:
                params["text"] = key
            self.call("Input.dispatchKeyEvent", params)

    def mouse(self, kind, x, y, **more):
        self.call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, **more})

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=1)

    def drag(self, x0, y0, x1, y1):
        self.mouse("mousePressed", x0, y0, button="left", clickCount=1)
        self.mouse("mouseMoved", x1, y1, button="left", buttons=1)
        self.mouse("mouseReleased", x1, y1, button="left", clickCount=1)

    def screenshot(self):
        """The window's picture, as the bytes of a PNG."""
        return base64.b64decode(self.call("Page.captureScreenshot", {"format": "png"})["data"])
