#!/usr/bin/env bash
# Makes the peers' own environment, benchmarks/fem/.venv, with touchwarp beside them in it.
set -euo pipefail
here="$(cd "$(dirname "$0")" && pwd)"
python="${PYTHON:-python3}"
"$python" -m venv "$here/.venv"
"$here/.venv/bin/python" -m pip install --quiet -r "$here/requirements.txt"
"$here/.venv/bin/python" -m pip install --quiet -e "$here/../.."
"$here/.venv/bin/python" - <<'PY'
try:
    import gmsh
except OSError as missing:
    raise SystemExit(f"gmsh cannot load: {missing}. On Debian: apt-get install libglu1-mesa libxft2 "
                     "libxcursor1 libxinerama1 libxrender1")
import ngsolve, netgen, skfem, pyamg
print("ngsolve", ngsolve.__version__, "| scikit-fem", skfem.__version__,
      "| gmsh", gmsh.__version__, "| pyamg", pyamg.__version__)
PY
