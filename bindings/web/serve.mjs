// Serves bindings/web/dist on the loopback address, for those who have no `rhexis view`: `node serve.mjs [PORT]`.

import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const root = join(fileURLToPath(new URL(".", import.meta.url)), "dist");
const types = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".wasm": "application/wasm" };

/** Begins to serve; the server and the page's address. */
export function serve(port = 8573) {
  const server = createServer(async (request, response) => {
    const path = normalize(new URL(request.url, "http://localhost").pathname);
    if (path === "/") return response.writeHead(302, { location: "/page/index.html" }).end();
    try {
      const bytes = await readFile(join(root, path.endsWith("/") ? `${path}index.html` : path));
      response.writeHead(200, { "content-type": `${types[extname(path)] ?? "application/octet-stream"}`, "cache-control": "no-cache" }).end(bytes);
    } catch {
      response.writeHead(404).end("not found\n");
    }
  });
  return new Promise((resolve) => server.listen(port, "127.0.0.1", () => {
    resolve({ server, address: `http://127.0.0.1:${server.address().port}/page/index.html` });
  }));
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { address } = await serve(Number(process.argv[2] ?? 8573));
  console.log(`the page is at ${address}; Ctrl-C ends`);
}
