"""Underwater vehicles in six degrees of freedom, after Fossen: equations of motion.

M dν/dt + C(ν) ν + D(ν) ν + g(η) = τ and dη/dt = J(η) ν: M and C of the rigid body and of the water
that moves with it, D linear and quadratic damping, g weight and buoyancy, τ what thrusters do. Axes
of the body are forward, starboard, down; of the world x, y, down; angles are roll, pitch, yaw.

References
----------
T. I. Fossen, "Handbook of Marine Craft Hydrodynamics and Motion Control", 2nd edition, Wiley, 2021.

M. von Benzon, F. F. Sørensen, E. Uth, J. Jouffroy, J. Liniger, S. Pedersen, "An Open-Source
Benchmark Simulator: Control of a BlueROV2 Underwater Robot", Journal of Marine Science and
Engineering 10(12), 1898, 2022: the parameters of the vehicle.
"""

from dataclasses import dataclass, field

import numpy as np

Array = np.ndarray

GRAVITY = 9.81  # m/s²
SEA_WATER = 1025.0  # kg/m³


def _column(*numbers: float) -> Array:
    return np.array(numbers)[:, None]


@dataclass(frozen=True)
class Parameters:
    """A vehicle in SI units, as a BlueROV2 in its heavy configuration by default.

    Columns have surge, sway, heave, roll, pitch, yaw. The centre of gravity is the origin of the
    body, whose inertia is diagonal; that of buoyancy is so far above it.
    """

    mass: float = 13.5
    volume: float = 0.0134
    buoyancy_above: float = 0.01
    inertia: Array = field(default_factory=lambda: _column(0.26, 0.23, 0.37))
    added: Array = field(default_factory=lambda: _column(6.36, 7.12, 18.68, 0.189, 0.135, 0.222))
    linear: Array = field(default_factory=lambda: _column(13.7, 0.0, 33.0, 0.0, 0.8, 0.0))
    quadratic: Array = field(default_factory=lambda: _column(141.0, 217.0, 190.0, 1.19, 0.47, 1.5))

    @property
    def total_mass(self) -> Array:
        """Diagonal of M, shape ``(6, 1)``."""
        return np.concatenate((np.full((3, 1), self.mass), self.inertia)) + self.added

    @property
    def weight(self) -> float:
        """Newtons."""
        return self.mass * GRAVITY

    @property
    def buoyancy(self) -> float:
        """Newtons in sea water."""
        return self.volume * SEA_WATER * GRAVITY


class Vehicles:
    """Vehicles of one kind, and where they are.

    Attributes
    ----------
    pose
        η, shape ``(6, n)``: metres in the world, radians.
    velocity
        ν, shape ``(6, n)``: m/s and rad/s along the axes of the body.
    """

    def __init__(self, n: int, parameters: Parameters) -> None:
        self.parameters = parameters
        self._mass = parameters.total_mass
        self.pose = np.zeros((6, n))
        self.velocity = np.zeros((6, n))

    def reset(self) -> None:
        """Put all at the origin, at rest."""
        self.pose[:] = 0.0
        self.velocity[:] = 0.0

    def step(self, forces: Array, step_s: float) -> None:
        """Go on by a step under forces and moments of thrusters, shape ``(6, n)``.

        The velocity comes first, and moves the vehicle: so oscillations gain no energy.
        """
        known = self.parameters
        damping = (known.linear + known.quadratic * np.abs(self.velocity)) * self.velocity
        total = forces - self._coriolis() - damping - self._restoring()
        self.velocity += total / self._mass * step_s
        self.pose += self.world_velocity() * step_s

    def world_velocity(self) -> Array:
        """Return J(η) ν, shape ``(6, n)``."""
        u, v, w, p, q, r = self.velocity
        (sin_roll, sin_pitch, sin_yaw), (cos_roll, cos_pitch, cos_yaw) = self._angles()
        ahead = cos_pitch * u + sin_pitch * (sin_roll * v + cos_roll * w)
        aside = cos_roll * v - sin_roll * w
        turn = sin_roll * q + cos_roll * r
        return np.array(
            (
                cos_yaw * ahead - sin_yaw * aside,
                sin_yaw * ahead + cos_yaw * aside,
                cos_pitch * (sin_roll * v + cos_roll * w) - sin_pitch * u,
                p + turn * sin_pitch / cos_pitch,
                cos_roll * q - sin_roll * r,
                turn / cos_pitch,
            )
        )

    def _angles(self) -> tuple[Array, Array]:
        """Return sines and cosines of roll, pitch and yaw, each of shape ``(3, n)``."""
        angles = self.pose[3:]
        return np.sin(angles), np.cos(angles)

    def _coriolis(self) -> Array:
        """Return C(ν) ν of body and added mass: momenta in axes that turn, after Kirchhoff."""
        momentum = self._mass * self.velocity
        linear, angular = momentum[:3], momentum[3:]
        speed, turn = self.velocity[:3], self.velocity[3:]
        moments = _cross(turn, angular) + _cross(speed, linear)
        return np.concatenate((_cross(turn, linear), moments))

    def _restoring(self) -> Array:
        """Return g(η): weight at the origin, buoyancy above it."""
        known = self.parameters
        (sin_roll, sin_pitch, _), (cos_roll, cos_pitch, _) = self._angles()
        rest = known.weight - known.buoyancy
        lever = known.buoyancy * known.buoyancy_above
        level = np.zeros_like(sin_roll)
        return np.array(
            (
                rest * sin_pitch,
                -rest * cos_pitch * sin_roll,
                -rest * cos_pitch * cos_roll,
                lever * cos_pitch * sin_roll,
                lever * sin_pitch,
                level,
            )
        )


def _cross(a: Array, b: Array) -> Array:
    """Return the cross products of columns; numpy's own takes five times as long for so few."""
    (x, y, z), (u, v, w) = a, b
    return np.array((y * w - z * v, z * u - x * w, x * v - y * u))
