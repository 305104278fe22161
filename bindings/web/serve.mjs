// Serves bindings/web/dist on the loopback address, for those who have no `rhexis view`: `node serve.mjs [MESH] [PORT]`. MESH is a mesh file to tear.

import { createServer } from "node:http";
import { existsSync } from "node:fs";
import { readFile } from "node:fs/promises";
import { basename, extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(fileURLToPath(new URL(".", import.meta.url)), "dist");
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };

/** Begins to serve, with a mesh to begin with; the server and the page's address. */
export function serve(port = 8573, mesh = null) {
  const start = { scene: null, set: [], files: [], mesh: mesh && { name: basename(mesh), at: "start/0" } };
  const index = `/page/index.html${mesh ? "?start=../start.json" : ""}`;
  const server = createServer(async (request, response) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    if (path === "/") return response.writeHead(302, { location: index }).end();
    if (mesh && path === "/start.json") return response.writeHead(200, { "content-type": "application/json" }).end(JSON.stringify(start));
    try {
      const file = mesh && path === "/start/0" ? mesh : join(root, path.endsWith("/") ? `${path}index.html` : path);
      const bytes = await readFile(file);
      response.writeHead(200, { "content-type": `${types[extname(path)] ?? "application/octet-stream"}`, "cache-control": "no-cache" }).end(bytes);
    } catch {
      response.writeHead(404).end("not found\n");
    }
  });
  return new Promise((resolve, reject) => server.once("error", reject).listen(port, "127.0.0.1", () => {
    resolve({ server, address: `http://127.0.0.1:${server.address().port}${index}` });
  }));
}

function stop(why) {
  console.error(`serve.mjs: ${why}`);
  process.exit(1);
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const given = process.argv.slice(2);
  const mesh = given.length && !/^\d+$/.test(given[0]) ? given.shift() : null;
  const port = Number(given[0] ?? 8573);
  if (mesh && !existsSync(mesh)) stop(`${mesh} is not there: give the path of a mesh file`);
  if (!existsSync(join(root, "page/index.html"))) stop("the page is not built: bindings/web/build.sh simd builds it");
  const { address } = await serve(port, mesh).catch((error) => stop(`cannot serve: ${error.message}; give another port as the last argument`));
  console.log(`the page is at ${address}; Ctrl-C ends`);
}
