import { defineConfig } from "vite";

export default defineConfig({
  base: "./", // the page is also exported to folders of other hosts
  resolve: { conditions: ["source", "module", "browser", "development|production"] },
  build: { target: "es2022" },
});
