import { defineConfig } from "vitest/config";

export default defineConfig({
  resolve: { conditions: ["source"] },
  ssr: { resolve: { conditions: ["source"] } },
  test: {
    testTimeout: 60_000, // on a busy machine
    maxWorkers: "100%", // else one core is left idle, which is half of a machine of two
    include: ["runtime/test/**/*.test.ts", "page/test/**/*.test.ts"],
  },
});
