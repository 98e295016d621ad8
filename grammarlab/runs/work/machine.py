"""What the last bits of results depend on: the software of a process, and the class of its processor.

NumPy and OpenBLAS choose their instructions when they are loaded. With and without AVX-512, exp, log, pow, tan, arctan
and cbrt differ in their last bits, and products of matrices differ by type of core.
"""

from __future__ import annotations

import platform
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from typing import Any, Self

from grammarlab.about import __version__
from grammarlab.runs.work.json_members import texts

_LIBRARIES = ("numpy", "scipy", "shapely", "pyarrow")
PINNED = 'NPY_DISABLE_CPU_FEATURES="X86_V4 AVX512_ICL AVX512_SPR" OPENBLAS_CORETYPE=Haswell'
"""Variables that put x86 processors with and without AVX-512 into one class, set before a process starts."""


@dataclass(frozen=True, slots=True)
class Machine:
    """Software and class of the processor; processes with equal ones make results that are equal to the last bit."""

    software: Mapping[str, str]
    """Version by name; of Python the first two numbers."""
    processor: Mapping[str, str]
    """Instructions that NumPy uses, and the type of core that OpenBLAS uses."""

    def difference(self, other: Machine) -> str:
        """First difference: ``numpy 2.4.6, not 2.3.0``; empty if there is none."""
        theirs = {**other.software, **other.processor}
        for name, value in {**self.software, **self.processor}.items():
            if theirs.get(name) != value:
                return f"{name} {value}, not {theirs.get(name, 'none')}"
        return ""

    def as_json(self) -> dict[str, dict[str, str]]:
        """Plain values for `from_json`."""
        return {"software": dict(self.software), "processor": dict(self.processor)}

    @classmethod
    def from_json(cls, values: Any, where: str) -> Self:
        """Machine from the values of `as_json`.

        Raises:
            AssetError: If they are others.
        """
        return cls(texts(values, "software", where), texts(values, "processor", where))


def this_machine() -> Machine:
    """The machine of this process."""
    # Both load their OpenBLAS, which chooses a type of core then.
    import scipy.linalg  # noqa: F401, PLC0415
    import shapely  # noqa: PLC0415
    from threadpoolctl import threadpool_info  # noqa: PLC0415

    cores = sorted({str(entry.get("architecture")) for entry in threadpool_info() if "blas" in entry["internal_api"]})
    return Machine(
        software={
            "grammarlab": __version__,
            "Python": ".".join(map(str, sys.version_info[:2])),
            "system": f"{platform.system()} {platform.machine()}",
            **{name: version(name) for name in _LIBRARIES},
            "GEOS": shapely.geos_version_string,
        },
        processor={"instructions": _instructions(), "BLAS": " ".join(cores)},
    )


def _instructions() -> str:
    """Sets of instructions that NumPy chooses from and that are enabled, largest last."""
    numpy_core = import_module("numpy._core._multiarray_umath")
    features: Mapping[str, bool] = getattr(numpy_core, "__cpu_features__", {})
    levels = [*getattr(numpy_core, "__cpu_baseline__", ()), *getattr(numpy_core, "__cpu_dispatch__", ())]
    return " ".join(level for level in levels if features.get(level))
