// Shows messages, also where the other scripts cannot run.
"use strict";

// Shows a text over the picture; an empty one hides it. The user can close it if it does not end the page.
function showMessage(text, canBeClosed = false) {
  const message = document.getElementById("message");
  message.textContent = text;
  if (!text || !canBeClosed) return;
  const close = document.createElement("button");
  close.textContent = "Close";
  close.addEventListener("click", () => {
    showMessage("");
    document.getElementById("canvas").focus();
  });
  message.append(close);
}

function fail(text) {
  document.documentElement.dataset.state = "failed";
  showMessage(text);
}

document.documentElement.dataset.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";
addEventListener("error", (event) =>
  fail(`The page has failed: ${event.message}. Reload it, or open it in another browser.`),
);
addEventListener("unhandledrejection", (event) =>
  fail(`The page has failed: ${event.reason?.message ?? event.reason}. Reload it.`),
);
if (location.protocol === "file:") {
  fail("A browser does not run this page from the disk. Serve its folder, for example with: python3 -m http.server");
} else if (!document.createElement("canvas").getContext("webgl2")) {
  fail(
    "This browser shows no 3D graphics (WebGL 2). Turn on hardware acceleration in its settings, update the " +
      "graphics driver, or open the page in another browser.",
  );
}
