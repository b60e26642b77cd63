"""Firefox and WebKit (Safari's engine) under Xvfb, driven as browser.py drives Chromium: Firefox by Marionette, WebKit by
WebDriver. Nothing but the standard library and Debian's packages firefox-esr, webkit2gtk-driver, xvfb."""
import base64
import glob
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import urllib.error
import urllib.request

import browser

CONSOLE = """window.ffp_told = []; for (const kind of ['error', 'warn']) { const say = console[kind];
    console[kind] = (...all) => { ffp_told.push(all.join(' ')); say.apply(console, all); }; }
    addEventListener('error', (event) => ffp_told.push(String(event.message)));"""


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Engine:
    """One page, in a browser of its own with an empty profile."""

    def __init__(self):
        self.port, self.home, self.asked = free_port(), tempfile.mkdtemp(prefix="ffp-engine-"), 0
        env = dict(os.environ, HOME=self.home, LIBGL_ALWAYS_SOFTWARE="1", WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS="1")
        self.process = subprocess.Popen(["xvfb-run", "-a", "-s", "-screen 0 1400x900x24", *self.command()], env=env,
                                        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        try:
            self.begin()
        except BaseException:
            self.close()
            raise

    def close(self):
        os.killpg(self.process.pid, signal.SIGTERM)
        self.process.wait(timeout=30)
        shutil.rmtree(self.home, ignore_errors=True)

    def patiently(self, work):
        end = time.monotonic() + 60
        while True:
            try:
                return work()
            except OSError:
                if time.monotonic() > end:
                    raise browser.Failure(f"{self.name} does not begin") from None
                time.sleep(0.3)

    def run(self, script, timeout=600):
        """The value of an expression of the page's own scripts, which may be a promise."""
        self.asked += 1
        own = (f"Promise.resolve().then(() => ({script})).then((value) => {{ window.ffp_answer = [{self.asked}, value === undefined ? null : value]; }}, "
               f"(error) => {{ window.ffp_answer = [{self.asked}, null, String(error)]; }});")
        self.script(f"const s = document.createElement('script'); s.textContent = {json.dumps(own)}; document.head.append(s); s.remove();")
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            answer = json.loads(self.script("return JSON.stringify(window.ffp_answer || [0])"))
            if answer[0] == self.asked:
                if len(answer) > 2:
                    raise browser.Failure(answer[2])
                return answer[1]
            time.sleep(0.05)
        raise browser.Failure("in vain waited for " + script)

    def start(self, path, fresh=True):
        try:
            self.load(path, fresh, 200)
        except browser.Failure as failure:  # a busy machine's browser that lost a load: once more
            print(f"{self.name}: {failure}: loaded again")
            self.load(path, fresh, 300)

    def load(self, path, fresh, patience):
        self.go("file://" + os.path.abspath(path) + ("?fresh" if fresh else ""))
        self.run("(() => { " + CONSOLE + " })()")
        end = time.monotonic() + patience
        while not self.run("!!window.ready"):
            if time.monotonic() > end:
                raise browser.Failure("the page does not begin")
            time.sleep(0.2)
        assert self.run("window.ready", patience), self.run("document.getElementById('failure').textContent")


class Firefox(Engine):
    name = "Firefox"
    needs = ("xvfb-run", "firefox-esr")

    @staticmethod
    def found():
        return all(map(shutil.which, Firefox.needs))

    def command(self):
        with open(os.path.join(self.home, "user.js"), "w", encoding="utf-8") as file:
            file.write(f'user_pref("webgl.force-enabled", true);\nuser_pref("marionette.port", {self.port});\n'
                       'user_pref("dom.disable_open_during_load", false);\n'
                       'user_pref("browser.shell.checkDefaultBrowser", false);\nuser_pref("datareporting.policy.dataSubmissionEnabled", false);\n')
        return ["firefox-esr", "--marionette", "--profile", self.home, "--width", "520", "--height", "400"]

    def receive(self):
        while b":" not in self.left:
            self.left += self.socket.recv(65536)
        size, self.left = self.left.split(b":", 1)
        while len(self.left) < int(size):
            more = self.socket.recv(1 << 20)
            if not more:
                raise browser.Failure("Firefox is gone")
            self.left += more
        message, self.left = self.left[:int(size)], self.left[int(size):]
        return json.loads(message)

    def call(self, name, **parameters):
        message = json.dumps([0, 1, "WebDriver:" + name, parameters]).encode()
        self.socket.sendall(b"%d:%s" % (len(message), message))
        answer = self.receive()
        if answer[2]:
            raise browser.Failure(f"{name}: {answer[2].get('message')}")
        return answer[3]

    def begin(self):
        self.left = b""
        self.socket = self.patiently(lambda: socket.create_connection(("127.0.0.1", self.port), timeout=600))
        self.receive()
        self.call("NewSession")

    def go(self, url):
        self.call("Navigate", url=url)

    def script(self, text):
        return self.call("ExecuteScript", script=text, args=[])["value"]

    def handles(self):
        return self.call("GetWindowHandles")

    def turn_to(self, handle):
        self.call("SwitchToWindow", handle=handle)

    def click(self, selector):
        element = next(iter(self.call("FindElement", using="css selector", value=selector)["value"].values()))
        self.call("ElementClick", id=element)

    def picture(self):
        return base64.b64decode(self.call("TakeScreenshot", full=False)["value"])

    def close(self):
        if hasattr(self, "socket"):
            self.socket.close()
        super().close()


class WebKit(Engine):
    name = "WebKit"
    needs = ("xvfb-run", "WebKitWebDriver")

    @staticmethod
    def binary():
        return next(iter(glob.glob("/usr/lib/*/webkit2gtk-4.*/MiniBrowser")), None)

    @staticmethod
    def found():
        return WebKit.binary() and all(map(shutil.which, WebKit.needs))

    def command(self):
        return ["WebKitWebDriver", f"--port={self.port}"]

    def request(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        asked = urllib.request.Request(f"http://127.0.0.1:{self.port}{path}", data, {"Content-Type": "application/json"}, method=method)
        try:
            with urllib.request.urlopen(asked, timeout=600) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise browser.Failure(f"{path}: {error.read().decode()[:400]}") from None

    def begin(self):
        options = {"binary": self.binary(), "args": ["--automation"]}
        answer = self.patiently(lambda: self.request("POST", "/session", {"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": options}}}))
        self.at = "/session/" + answer["sessionId"]

    def go(self, url):
        self.request("POST", self.at + "/url", {"url": url})

    def script(self, text):
        return self.request("POST", self.at + "/execute/sync", {"script": text, "args": []})

    def handles(self):
        return self.request("GET", self.at + "/window/handles")

    def turn_to(self, handle):
        self.request("POST", self.at + "/window", {"handle": handle})

    def click(self, selector):
        element = next(iter(self.request("POST", self.at + "/element", {"using": "css selector", "value": selector}).values()))
        self.request("POST", f"{self.at}/element/{element}/click", {})

    def picture(self):
        return base64.b64decode(self.request("GET", self.at + "/screenshot"))

    def close(self):
        if hasattr(self, "at"):
            self.request("DELETE", self.at)
        super().close()
