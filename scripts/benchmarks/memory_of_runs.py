"""Peak memory of runs of growing length in both formulations, for docs/verification/performance.md; some minutes.

    memory-of-runs [REVOLUTIONS...]       default: 10 100 1000

The table is that of docs/reference/security.md.
"""
import tempfile

from measure import RIG, Table, program, run


def main(*revolutions):
    freeplay = program("freeplay")
    table = Table("revolutions", "penalty, MB", "with forces.csv", "nonsmooth, MB", "with forces.csv")
    for turns in revolutions or (10, 100, 1000):
        row = []
        for formulation in ("penalty", "nonsmooth"):
            for forces in ("false", "true"):
                with tempfile.TemporaryDirectory() as place:
                    # Rows and samples grow with the length. Coarse steps save time.
                    cost = run(freeplay, RIG, f"{place}/run", formulation, run__revolutions=turns, run__discard=0,
                               run__output_step=1e-3, run__forces=forces, nonsmooth__step=5e-5,
                               penalty__tolerance=1e-6)["cost"]
                row.append(f"{cost['peak_memory_KiB'] * 1024 / 1e6:.1f}")
        table.row(turns, *row)
