// SPDX-License-Identifier: Apache-2.0
// Search in pages opened from disk, where browsers refuse to start workers. The worker's script runs in a hidden frame instead.
if (location.protocol === "file:") {
    window.Worker = class extends EventTarget {
        constructor(url) {
            super();
            const frame = document.createElement("iframe");
            frame.hidden = true;
            frame.srcdoc = `<script src="${url}"></script>`;
            this.inside = new Promise((resolve) => {
                frame.onload = () => {
                    const inside = frame.contentWindow;
                    // Messages from the script arrive here.
                    inside.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
                    resolve(inside);
                };
            });
            document.body.append(frame);
        }

        postMessage(data) {
            this.inside.then((inside) => inside.dispatchEvent(new MessageEvent("message", { data })));
        }
    };
}
