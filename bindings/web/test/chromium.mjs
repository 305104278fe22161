// Headless Chromium for tests: RHEXIS_CHROMIUM is its path, by default that of the system's package.

import { existsSync } from "node:fs";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const PATHS = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];
const ARGUMENTS = [
  "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
  "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
];

/** Starts the browser with a profile of its own, which goes when it is closed; ends the process where there is no browser. */
export async function launch(viewport) {
  const executablePath = process.env.RHEXIS_CHROMIUM ?? PATHS.find((path) => existsSync(path));
  if (!executablePath) {
    console.error("Chromium is not there: install your system's package chromium, or give its path as RHEXIS_CHROMIUM");
    process.exit(1);
  }
  const profile = await mkdtemp(join(tmpdir(), "rhexis-browser-"));
  const context = await chromium.launchPersistentContext(profile, { executablePath, headless: true, args: ARGUMENTS, viewport });
  const close = async () => {
    await context.close();
    await rm(profile, { recursive: true, force: true });
  };
  return { context, profile, close };
}
