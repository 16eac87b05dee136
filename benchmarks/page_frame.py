"""What displacing both hands takes at each frame of the headset, in the page, in a real Chromium.

    python benchmarks/page_frame.py [SCENE.toml] [--json FILE]

The demo's mug (to 0.5 mm) unless a scene is given, entered with an emulated headset and calibrated
by touch. Measured is everything that happens between reading the joints and drawing: nearest places
of the prop for ten fingertips, the lookup, both whole hands by inverse kinematics, contacts and the
audit; with both hands touching, at 100 pairs of places, around which they move by up to 1 mm a
frame, since places are sought from where they were.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from demo_page import demo_scene, served
from figures import Figure, print_figures, save_json

import touchwarp as tw
from tests.browser.headset import Headset
from tests.browser.person import Person, RealProp, touchable

CALLS = 20
TIMES = """(calls) => {
  const { displacement, inputs } = touchwarpProbe;
  const spent = { all: 0, hands: 0, contacts: 0 };
  const timed = (object, name, part) => {
    const method = object[name];
    object[name] = (...given) => {
      const begin = headset.now();
      const result = method.apply(object, given);
      spent[part] += headset.now() - begin;
      return result;
    };
    return () => delete object[name];
  };
  const restore = displacement.hands.map((hand) => timed(hand, "update", "hands"));
  restore.push(timed(displacement.watch, "update", "contacts"));
  const still = inputs.map(({ poses }) => poses.slice());
  for (let k = 0; k < calls; k++) {
    inputs.forEach(({ poses }, side) => {
      for (let at = 0; at < poses.length; at++) {
        const axis = (at % 16) - 12;
        const moved = axis >= 0 && axis < 3 ? 0.002 * Math.sin(0.5 * k + axis) : 0;
        poses[at] = still[side][at] + moved;
      }
    });
    const begin = headset.now();
    displacement.update(1e3 + 1e-3 * k, inputs, true);
    spent.all += headset.now() - begin;
  }
  inputs.forEach(({ poses }, side) => poses.set(still[side]));
  for (const each of restore) each();
  return [spent.all / calls, spent.hands / calls, spent.contacts / calls];
}"""


def measure(scene: Path) -> list[Figure]:
    """Times in ms a frame of two hands."""
    with served(scene) as (address, browser):
        page = browser.new_page(viewport={"width": 800, "height": 400})
        headset = Headset(page)
        headset.open(address)
        headset.enter()
        mug = RealProp(tw.load_scene(scene).props[0])
        person = Person(headset, mug)
        person.arrive()
        places = touchable(mug, 100, seed=1)
        left = person.touching(places[::-1], "left")
        right = person.touching(places)
        times = []
        for pair in zip(left, right, strict=True):
            headset.step([dict(zip(("left", "right"), pair, strict=True))])
            times.append(page.evaluate(TIMES, CALLS))
    whole, hands, contacts = np.transpose(times)
    return [
        Figure("both hands touching, median", float(np.median(whole)), "ms", at_most=0.2),
        Figure("the same, 95th percentile", float(np.percentile(whole, 95)), "ms"),
        Figure("the same, best", float(np.min(whole)), "ms"),
        Figure("of it nearest places, lookup and hands", float(np.median(hands)), "ms"),
        Figure("of it contacts and audit", float(np.median(contacts)), "ms"),
    ]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scene", type=Path, nargs="?")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    with demo_scene(options.scene, tolerance_mm=0.5) as scene:
        figures = measure(scene)
    print_figures("both hands in the page", figures)
    if options.json:
        save_json(options.json, figures)


if __name__ == "__main__":
    main()
