# SPDX-License-Identifier: Apache-2.0
"""A page in headless Chromium with its software renderer, driven through the DevTools protocol over a pipe."""

import json
import os
import selectors
import shutil
import subprocess
import time

FLAGS = ("--headless=new", "--disable-dev-shm-usage", "--remote-debugging-pipe", "--no-first-run",
         "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
         "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--disable-gpu-watchdog",
         "--disable-background-networking", "--disable-component-update", "--disable-extensions", "--hide-scrollbars")


def chromium():
    """The path to Chromium, or None if it is not installed; BN_CHROMIUM overrides it."""
    names = [os.environ.get("BN_CHROMIUM"), "chromium", "chromium-browser", "google-chrome", "google-chrome-stable"]
    return next((path for name in names if name for path in [shutil.which(name)] if path), None)


class Browser:
    """One browser with one page."""

    def __init__(self, program, folder, seconds=60):
        self.seconds = seconds
        self.next_id = 0
        self.text = b""
        self.events = []
        self.session = None
        their_in, self.out = os.pipe()
        self.into, their_out = os.pipe()
        flags = [*FLAGS, *(["--no-sandbox"] if os.geteuid() == 0 else [])]  # Chromium has no sandbox for root
        # The protocol uses descriptors 3 and 4. Shells other than bash support only single-digit descriptors.
        command = ["bash", "-c", f'exec 3<&{their_in} 4>&{their_out} && exec "$@"', "bash", program, *flags,
                   f"--user-data-dir={folder}", "about:blank"]
        self.log = open(folder / "log", "wb")  # noqa: SIM115
        self.process = subprocess.Popen(command, pass_fds=(their_in, their_out), stdin=subprocess.DEVNULL,
                                        stdout=self.log, stderr=self.log)
        os.close(their_in)
        os.close(their_out)
        self.selector = selectors.DefaultSelector()
        self.selector.register(self.into, selectors.EVENT_READ)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network"):
            self.call(f"{domain}.enable")

    def close(self):
        os.close(self.out)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.into)
        self.log.close()

    def message(self):
        end = time.monotonic() + self.seconds
        while b"\0" not in self.text:
            if not self.selector.select(max(0, end - time.monotonic())):
                raise TimeoutError(f"the browser did not respond for {self.seconds} s")
            read = os.read(self.into, 1 << 16)
            if not read:
                raise ConnectionError(f"the browser exited; see {self.log.name}")
            self.text += read
        message, self.text = self.text.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **params):
        self.next_id += 1
        call = {"id": self.next_id, "method": method, "params": params}
        if self.session:
            call["sessionId"] = self.session
        os.write(self.out, json.dumps(call).encode() + b"\0")
        while True:
            message = self.message()
            if message.get("id") == self.next_id:
                assert "error" not in message, f"{method}: {message['error']}"
                return message["result"]
            self.events.append(message)

    def happened(self, name):
        """The parameters of all events with this name since open()."""
        return [event["params"] for event in self.events if event.get("method") == name]

    def open(self, address, width, height, ratio=1, dark=False):
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=ratio, mobile=ratio > 1)
        self.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])
        self.events.clear()
        self.call("Page.navigate", url=address)
        while not self.happened("Page.loadEventFired"):
            self.events.append(self.message())

    def value(self, expression):
        """The value of an expression, or the value its promise resolves to."""
        result = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, result["exceptionDetails"]
        return result["result"].get("value")

    def wait(self, condition):
        end = time.monotonic() + self.seconds
        while not self.value(condition):
            assert time.monotonic() < end, f"not in {self.seconds} s: {condition}"
            time.sleep(0.05)

    def press(self, key):
        for kind in ("rawKeyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode={"Tab": 9, "ArrowLeft": 37, "ArrowRight": 39, "Home": 36, "End": 35}[key])
