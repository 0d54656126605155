"""Makes rig.csv: a minute and a half of a made-up friction rig, as its logger wrote it.

Motor and belt turn a shaft at a fiftieth of the motor's speed. The bearing's drag grows with the oil's pressure, which
is in no nominal simulation; the rest is inertia, Coulomb and viscous friction. The torque constant is 0.21 N·m/A.

    python docs/examples/rig.py > rig.csv
"""

import numpy as np

RATE, SECONDS, RATIO, TORQUE_CONSTANT = 50, 90, 50.0, 0.21


def main() -> None:
    """Print the table."""
    rng = np.random.default_rng(14)
    time = np.arange(RATE * SECONDS) / RATE
    corners = np.arange(0.0, SECONDS + 1.0, 3.0)
    speed = np.interp(time, corners, rng.uniform(-90.0, 90.0, corners.size))
    angle = np.concatenate(([0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) / RATE)))
    pressure = 3.0 + 0.9 * np.sin(2 * np.pi * time / 23.0) + 0.4 * np.sin(2 * np.pi * time / 7.7)
    torque = 1.5e-3 * np.gradient(speed, time) + 0.35 * np.tanh(speed / 2.0) + 2.5e-3 * speed
    torque += 0.12 * (pressure - 3.0) * np.tanh(speed / 2.0) + rng.normal(0.0, 0.02, time.size)
    print("Prüfstand 7;Lauf 12;;;")
    print("Zeit [s];Winkel Motor [°];Winkel Abtrieb [°];Motorstrom [A];Öldruck [bar]")
    degrees = np.degrees(angle)
    for row in zip(time, degrees % 360.0, degrees / RATIO, torque / TORQUE_CONSTANT, pressure, strict=True):
        print(
            ";".join(f"{value:.{places}f}" for value, places in zip(row, (2, 2, 4, 4, 3), strict=True)).replace(
                ".", ","
            )
        )


if __name__ == "__main__":
    main()
