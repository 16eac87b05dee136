import { defineConfig } from "vitest/config";

export default defineConfig({
  resolve: { conditions: ["source"] },
  ssr: { resolve: { conditions: ["source"] } },
  test: { include: ["runtime/test/**/*.test.ts", "page/test/**/*.test.ts"] },
});
