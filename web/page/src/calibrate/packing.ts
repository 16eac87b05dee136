import { Matrix } from "ml-matrix";
import { Quaternion, Vector3 } from "three";
import type { Calibration } from "./assess.js";
import type { Contact } from "./contact.js";
import type { Suggestion } from "./nextTouch.js";
import { type Freedom, Pose } from "./pose.js";

/** What goes to the worker that registers, and what comes back: plain numbers, to be cloned. */
export interface PackedTask {
  readonly contacts: readonly PackedContact[];
  readonly freedom: Freedom;
}

interface PackedContact {
  readonly tip: number[];
  readonly turn: number[];
  readonly radius: number;
  readonly time: number;
  readonly named: { readonly point: number[]; readonly normal: number[] } | null;
}

type PackedPose = readonly [turn: number[], place: number[]];

interface PackedCalibration {
  readonly pose: PackedPose;
  readonly tipOffset: number[];
  readonly covariance: { readonly toHand: number[][]; readonly inRoom: number[][] };
  readonly translation95: number[];
  readonly turn95: number;
  readonly turns95: readonly number[];
  readonly turnAxis: number[];
  readonly rivals: readonly PackedPose[];
  readonly scale: number;
  readonly doubts: Calibration["doubts"];
}

export interface PackedFinding {
  readonly calibration: PackedCalibration | null;
  readonly suggestion: { point: number[]; normal: number[]; doubt: number } | null;
  readonly harmless: boolean;
}

/** Where the prop stands, as far as touches have told. */
export interface Finding {
  /** Null before there are enough touches. */
  readonly calibration: Calibration | null;
  /** Where to touch next. */
  readonly suggestion: Suggestion | null;
  /** Whether what is in doubt changes nothing of what is displayed. */
  readonly harmless: boolean;
}

export function packContacts(contacts: readonly Contact[]): PackedContact[] {
  return contacts.map(({ tip, turn, radius, time, named }) => ({
    tip: tip.toArray(),
    turn: turn.toArray(),
    radius,
    time,
    named: named ? { point: named.point.toArray(), normal: named.normal.toArray() } : null,
  }));
}

export function unpackContacts(contacts: readonly PackedContact[]): Contact[] {
  return contacts.map(({ tip, turn, radius, time, named }) => ({
    tip: vector(tip),
    turn: new Quaternion().fromArray(turn),
    radius,
    time,
    ...(named ? { named: { point: vector(named.point), normal: vector(named.normal) } } : {}),
  }));
}

export function packFinding({ calibration, suggestion, harmless }: Finding): PackedFinding {
  return {
    calibration: calibration && {
      pose: packPose(calibration.pose),
      tipOffset: calibration.tipOffset.toArray(),
      covariance: {
        toHand: calibration.covariance.toHand.to2DArray(),
        inRoom: calibration.covariance.inRoom.to2DArray(),
      },
      translation95: calibration.translation95.toArray(),
      turn95: calibration.turn95,
      turns95: calibration.turns95,
      turnAxis: calibration.turnAxis.toArray(),
      rivals: calibration.rivals.map(packPose),
      scale: calibration.scale,
      doubts: calibration.doubts,
    },
    suggestion: suggestion && {
      point: suggestion.point.toArray(),
      normal: suggestion.normal.toArray(),
      doubt: suggestion.doubt,
    },
    harmless,
  };
}

export function unpackFinding({ calibration, suggestion, harmless }: PackedFinding): Finding {
  return {
    calibration: calibration && {
      pose: unpackPose(calibration.pose),
      tipOffset: vector(calibration.tipOffset),
      covariance: {
        toHand: new Matrix(calibration.covariance.toHand),
        inRoom: new Matrix(calibration.covariance.inRoom),
      },
      translation95: vector(calibration.translation95),
      turn95: calibration.turn95,
      turns95: calibration.turns95,
      turnAxis: vector(calibration.turnAxis),
      rivals: calibration.rivals.map(unpackPose),
      scale: calibration.scale,
      doubts: calibration.doubts,
    },
    suggestion: suggestion && {
      point: vector(suggestion.point),
      normal: vector(suggestion.normal),
      doubt: suggestion.doubt,
    },
    harmless,
  };
}

function packPose({ turn, place }: Pose): PackedPose {
  return [turn.toArray(), place.toArray()];
}

function unpackPose([turn, place]: PackedPose): Pose {
  return new Pose(new Quaternion().fromArray(turn), vector(place));
}

function vector(numbers: readonly number[]): Vector3 {
  return new Vector3().fromArray(numbers as number[]);
}
