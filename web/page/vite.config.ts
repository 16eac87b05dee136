import { defineConfig } from "vite";

export default defineConfig({
  base: "./", // the page is also exported to folders of other hosts
  resolve: { conditions: ["source", "module", "browser", "development|production"] },
  build: {
    target: "es2022",
    outDir: "../../src/touchwarp/live/page", // served from, and packed with, the Python package
    emptyOutDir: true,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1000, // three.js
  },
});
