#!/usr/bin/env python3
"""Makes the observations of assets/observations with a ball of its own, so that tunenet is not judged by itself.

    python3 assets/make_observations.py [FOLDER]

Flight is integrated by Runge-Kutta steps, impacts are found as roots of the height, and the impulse is that of a solid
sphere with Coulomb friction. Equal runs write equal bytes. Standard library only. SI units, z up.
"""

import math
import pathlib
import random
import sys

GRAVITY = 9.81
STEP_S = 1e-3  # the classical method's error at this step is far below the last digit that is written
REST_M_S = 1e-4  # a ball that comes slower stays down


def slope(state, drag):
    """The time derivative of (position, velocity)."""
    velocity = state[3:]
    speed = math.sqrt(sum(v * v for v in velocity))
    ax, ay, az = (-drag * speed * v for v in velocity)
    return (*velocity, ax, ay, az - GRAVITY)


def flown(state, h, drag):
    """The state after flying for h seconds: one classical Runge-Kutta step."""

    def ahead(k, h):
        return tuple(s + h * d for s, d in zip(state, k))

    a = slope(state, drag)
    b = slope(ahead(a, h / 2), drag)
    c = slope(ahead(b, h / 2), drag)
    d = slope(ahead(c, h), drag)
    return tuple(s + h / 6 * (p + 2 * q + 2 * r + t) for s, p, q, r, t in zip(state, a, b, c, d))


def bounced(state, spin, radius, restitution, friction):
    """Velocity and spin after an impact on level ground. Impulses are per mass."""
    x, y, z, vx, vy, vz = state
    wx, wy, wz = spin
    normal = -(1 + restitution) * vz
    # How the lowest point slides; it sticks when friction can stop it, and 2/7 of the slide is what that takes.
    ux, uy = vx - radius * wy, vy + radius * wx
    slide = math.hypot(ux, uy)
    tangential = min(friction * normal, 2 / 7 * slide)
    jx, jy = (-tangential * ux / slide, -tangential * uy / slide) if slide > 0 else (0.0, 0.0)
    k = 5 / (2 * radius)  # mass over moment of inertia, times the radius
    return (x, y, z, vx + jx, vy + jy, -restitution * vz), (wx + k * jy, wy - k * jx, wz)


class Ball:
    """A ball that is let go at time 0 and followed from impact to impact."""

    def __init__(self, centre, velocity=(0, 0, 0), *, radius=0.02, floor, restitution, friction=0.0, drag=0.0):
        self.time, self.state, self.spin = 0.0, (*map(float, centre), *map(float, velocity)), (0.0, 0.0, 0.0)
        self.radius, self.ground = radius, floor + radius
        self.restitution, self.friction, self.drag = restitution, friction, drag
        self.resting, self.impacts = False, []

    def advance(self, until):
        """Moves on to `until`."""
        while not self.resting and until - self.time > 1e-12:
            h = min(STEP_S, until - self.time)
            after = flown(self.state, h, self.drag)
            if after[2] >= self.ground:
                self.state, self.time = after, self.time + h
                continue
            low, high = 0.0, h  # the root of the height by bisection, down to the clock's last bit
            for _ in range(60):
                middle = (low + high) / 2
                if flown(self.state, middle, self.drag)[2] >= self.ground:
                    low = middle
                else:
                    high = middle
            self.time += high
            self.impacts.append(self.time)
            state = flown(self.state, high, self.drag)
            state = (*state[:2], self.ground, *state[3:])
            self.state, self.spin = bounced(state, self.spin, self.radius, self.restitution, self.friction)
            if self.state[5] < REST_M_S:
                self.resting = True
        self.time = max(self.time, until)
        return self.state[:3]


def positions(path, ball, *, rate, frames, lead, noise, seed):
    """Writes `frames` rows of the centre; the ball is held for the first `lead` seconds."""
    draw = random.Random(seed)
    lines = ["t_s,x_m,y_m,z_m"]
    for k in range(frames):
        seen = ball.advance(max(0.0, k / rate - lead))
        lines.append(",".join([f"{k / rate:.6f}", *(f"{v + draw.gauss(0, noise):.5f}" for v in seen)]))
    path.write_bytes(("\n".join(lines) + "\n").encode())


def bounces(path, ball, *, count, start, noise, seed):
    """Writes the first `count` impact times on a clock that read `start` at the release."""
    draw = random.Random(seed)
    while len(ball.impacts) < count:
        ball.advance(ball.time + 0.1)
    times = [start + t + draw.gauss(0, noise) for t in ball.impacts[:count]]
    path.write_bytes(("\n".join(["bounce_time_s", *(f"{t:.6f}" for t in times)]) + "\n").encode())


def main():
    folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parent / "observations")
    folder.mkdir(parents=True, exist_ok=True)
    ball = Ball((0.3, -0.2, 0.113 + 0.02 + 1.0), floor=0.113, restitution=0.83)
    positions(folder / "drop.csv", ball, rate=120, frames=360, lead=0.25, noise=2e-3, seed=1)
    ball = Ball((0.0, 0.0, 0.6), (5.0, 1.2, 0.5), floor=0.0, restitution=0.75, friction=0.2)
    positions(folder / "throw.csv", ball, rate=120, frames=180, lead=0.0, noise=2e-3, seed=2)
    ball = Ball((0.0, 0.0, 0.02 + 0.8), floor=0.0, restitution=0.9)
    bounces(folder / "bounces.csv", ball, count=12, start=1.37, noise=2e-4, seed=3)
    ball = Ball((0.0, 0.0, 0.76 + 0.02 + 1.5), floor=0.76, restitution=0.88, drag=0.1317)
    positions(folder / "table_tennis.csv", ball, rate=120, frames=300, lead=0.25, noise=2e-3, seed=4)
    # A light ball thrown in several directions and at several speeds, in air that a scene may lack.
    throws = [
        ((0.0, 0.0, 1.2), (2.0, 0.5, 1.0)),
        ((0.1, -0.2, 0.9), (-1.0, 3.5, 0.5)),
        ((-0.2, 0.1, 1.5), (-4.5, -1.5, 0.0)),
        ((0.0, 0.2, 1.1), (0.5, -2.5, 2.0)),
        ((0.1, 0.0, 1.4), (3.0, -3.0, -0.5)),
    ]
    for number, (centre, velocity) in enumerate(throws, 1):
        ball = Ball(centre, velocity, floor=0.0, restitution=0.8, drag=0.1317)
        positions(folder / f"light_{number}.csv", ball, rate=120, frames=216, lead=0.0, noise=2e-3, seed=10 + number)


if __name__ == "__main__":
    main()
