import { testCoverage } from "./coverage.js";

testCoverage("handBias");
