"""A headless Chromium, driven over the DevTools protocol through a pipe: messages of JSON ended by zero bytes,
https://chromedevtools.github.io/devtools-protocol/ . Standard library only."""
import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def find():
    """The path of a browser, or None."""
    named = os.environ.get("FFP_CHROMIUM")
    return named or next((path for path in map(shutil.which, NAMES) if path), None)


class Failure(Exception):
    pass


class Browser:
    """One page. console: what it said, errors and warnings first of all; requests: what it asked for."""

    def __init__(self, program, width=1280, height=720, arguments=()):
        self.profile = tempfile.mkdtemp(prefix="ffp-view-")
        to_browser, from_here = os.pipe()
        to_here, from_browser = os.pipe()

        def wire():  # the browser reads 3 and writes 4
            read, write = os.dup(to_browser), os.dup(from_browser)
            os.dup2(read, 3)
            os.dup2(write, 4)

        self.process = subprocess.Popen(
            [program, "--headless=new", "--no-sandbox", "--disable-gpu-sandbox", "--use-gl=angle",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--remote-debugging-pipe", "--no-first-run",
             "--disable-extensions", "--disable-background-networking", "--disable-component-update",
             "--use-fake-device-for-media-stream", "--use-fake-ui-for-media-stream",
             "--autoplay-policy=no-user-gesture-required", "--disable-popup-blocking", "--mute-audio",
             f"--user-data-dir={self.profile}", f"--window-size={width},{height}", *arguments, "about:blank"],
            preexec_fn=wire, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_browser)
        os.close(from_browser)
        self.write, self.read, self.left, self.last = from_here, to_here, b"", 0
        self.console, self.requests, self.targets, self.answers = [], [], [], {}
        self.asked, self.agrees = [], True  # kinds of dialogs, and what is answered
        self.crashed = set()  # sessions
        targets = self.call("Target.getTargets", session=None)["targetInfos"]
        page = next(t for t in targets if t["type"] == "page")
        self.session = self.call("Target.attachToTarget", {"targetId": page["targetId"], "flatten": True},
                                 session=None)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(domain + ".enable")
        self.resize(width, height)

    def close(self):
        try:
            self.call("Browser.close", session=None)
        except (Failure, OSError):
            self.process.kill()
        self.process.wait(timeout=20)
        os.close(self.write)
        os.close(self.read)
        shutil.rmtree(self.profile, ignore_errors=True)

    def _note(self, message):
        method, told = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            details = told["exceptionDetails"]
            self.console.append("exception: " + details.get("exception", {}).get("description", details["text"]))
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            self.console.append(told["type"] + ": " + " ".join(str(a.get("value", a.get("description")))
                                                               for a in told["args"]))
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            self.console.append(" ".join((told["entry"]["level"] + ":", told["entry"]["text"], told["entry"].get("url", ""))))
        elif method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        elif method == "Inspector.targetCrashed":
            self.crashed.add(message.get("sessionId"))
        elif method == "Page.javascriptDialogOpening":
            self.asked.append(told["type"])
            self._send("Page.handleJavaScriptDialog", {"accept": self.agrees}, message.get("sessionId", self.session))

    def _receive(self, end):
        while b"\0" not in self.left:
            ready, _, _ = select.select([self.read], [], [], max(0, end - time.monotonic()))
            if not ready:
                raise Failure("the browser does not answer")
            more = os.read(self.read, 1 << 20)
            if not more:
                raise Failure("the browser is gone")
            self.left += more
        text, _, self.left = self.left.partition(b"\0")
        return json.loads(text)

    def _send(self, method, parameters, session):
        self.last += 1
        message = {"id": self.last, "method": method, "params": parameters}
        if session:
            message["sessionId"] = session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write, data):]
        return self.last

    def call(self, method, parameters=None, session="", timeout=600):
        number = self._send(method, parameters or {}, self.session if session == "" else session)
        end = time.monotonic() + timeout
        while True:
            answer = self._receive(end)
            if answer.get("id") != number:
                self._note(answer)
            elif "error" in answer:
                raise Failure(f"{method}: {answer['error']['message']}")
            else:
                return answer["result"]

    def resize(self, width, height, scale=1, mobile=False):
        self.call("Emulation.setDeviceMetricsOverride",
                  {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": mobile})

    def scheme(self, name):
        self.call("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": name}]})

    def open(self, path):
        self.call("Page.navigate", {"url": path if "://" in path else "file://" + os.path.abspath(path)})

    def pages(self, mark):
        """The ids of the open pages whose addresses contain this."""
        targets = self.call("Target.getTargets", session=None)["targetInfos"]
        return [t["targetId"] for t in targets if t["type"] == "page" and mark in t["url"]]

    def attach(self, target):
        """A session with another page, for call and run."""
        session = self.call("Target.attachToTarget", {"targetId": target, "flatten": True}, session=None)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Inspector"):
            self.call(domain + ".enable", session=session)
        return session

    def run(self, script, timeout=600, session=""):
        """The value of an expression, which may be a promise."""
        answer = self.call("Runtime.evaluate", {"expression": script, "awaitPromise": True, "returnByValue": True,
                                                "userGesture": True}, timeout=timeout, session=session)
        if "exceptionDetails" in answer:
            details = answer["exceptionDetails"]
            raise Failure(details.get("exception", {}).get("description", details["text"]))
        return answer["result"].get("value")

    def wait(self, condition, timeout=300, every=0.05):
        """Asks more seldom the longer it lasts: every question costs the page time."""
        began = time.monotonic()
        while not self._holds(condition):
            waited = time.monotonic() - began
            if waited > timeout:
                raise Failure("in vain waited for " + condition)
            time.sleep(max(every, min(0.3, waited / 20)))

    def _holds(self, condition):
        try:
            return self.run(condition)
        except Failure as failure:
            if "navigated" in str(failure) or "context was destroyed" in str(failure):
                return False  # a page that is being loaded again has no answer yet
            raise

    def screenshot(self, path):
        data = self.call("Page.captureScreenshot", {"format": "png"})["data"]
        with open(path, "wb") as file:
            file.write(base64.b64decode(data))

    def mouse(self, kind, x, y, button="left", buttons=1, **more):
        self.call("Input.dispatchMouseEvent", {"type": kind, "x": x, "y": y, "button": button, "buttons": buttons,
                                               "clickCount": 1, **more})

    def drag(self, start, end, button="left", steps=6, **more):
        buttons = {"left": 1, "right": 2, "middle": 4}[button]
        self.mouse("mousePressed", *start, button, buttons, **more)
        for i in range(1, steps + 1):
            at = [a + (b - a) * i / steps for a, b in zip(start, end)]
            self.mouse("mouseMoved", *at, button, buttons, **more)
        self.mouse("mouseReleased", *end, button, 0, **more)

    def key(self, key, code=None, **more):
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", {"type": kind, "key": key, "code": code or key,
                                                 "text": key if kind == "keyDown" and len(key) == 1 else "", **more})
