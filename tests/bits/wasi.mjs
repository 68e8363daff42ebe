// Runs the program `bits`, compiled for wasm32-wasip1, in Node.js: node wasi.mjs BITS.wasm ROOT

import { readFileSync } from "node:fs";
import { argv, exit } from "node:process";
import { WASI } from "node:wasi";

const [module, root] = argv.slice(2);
const wasi = new WASI({ version: "preview1", args: ["bits", "/root"], preopens: { "/root": root } });
const { instance } = await WebAssembly.instantiate(readFileSync(module), wasi.getImportObject());
exit(wasi.start(instance));
