import { defineConfig } from "vitest/config";

export default defineConfig({
  resolve: { conditions: ["source"] },
  ssr: { resolve: { conditions: ["source"] } },
  test: {
    testTimeout: 60_000, // on a busy machine
    include: ["runtime/test/**/*.test.ts", "page/test/**/*.test.ts"],
  },
});
