// Unpacks the data of the runs and the program of the page, and starts the program.
"use strict";

// The data of each run, as bytes.
var runData = [];

// Shows a message in place of the animation, and the text that describes it.
function showMessage(text) {
  const message = document.getElementById("message");
  message.textContent = text;
}

function fail(text) {
  document.documentElement.dataset.state = "failed";
  showMessage(text);
}

// Returns the bytes of a base64 text.
function decodeText(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const characters = atob(text);
  const bytes = new Uint8Array(characters.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = characters.charCodeAt(i);
  return bytes;
}

// Returns the unpacked bytes of the elements, and removes the elements.
async function unpack(elements) {
  const stream = new ReadableStream({
    pull(controller) {
      const element = elements.shift();
      if (!element) {
        controller.close();
        return;
      }
      controller.enqueue(decodeText(element.textContent));
      element.remove();
    },
  });
  const unpacked = stream.pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

async function boot() {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  document.documentElement.dataset.theme = dark.matches ? "dark" : "light";
  if (typeof DecompressionStream === "undefined") {
    fail(
      "This browser cannot unpack the data of this page. Open the page in Chrome or Edge 80, Firefox 113, " +
        "Safari 16.4, or a later version.",
    );
    return;
  }
  if (!document.createElement("canvas").getContext("webgl2")) {
    fail(
      "This browser shows no 3D graphics (WebGL 2). Turn on hardware acceleration in its settings, update the " +
        "graphics driver, or open the page in another browser.",
    );
    return;
  }
  const elements = [];
  for (const element of document.querySelectorAll("script[data-run]")) {
    (elements[Number(element.dataset.run)] ??= []).push(element);
  }
  for (const run of elements) runData.push(await unpack(run));
  // The last one is the program.
  const program = document.createElement("script");
  program.textContent = new TextDecoder().decode(runData.pop());
  document.body.append(program);
}

addEventListener("error", (event) =>
  fail("The page has failed: " + event.message + ". Reload it, or open it in another browser."),
);
boot().catch((error) =>
  fail(
    "The data of this page cannot be unpacked: " +
      error.message +
      ". The file may be incomplete; copy it again, or write it again with supple.",
  ),
);
