import { testCoverage } from "./coverage.js";

testCoverage("roomBias");
