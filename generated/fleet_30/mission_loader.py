# Generated from mission fleet_30 by mission_loader.py.j2.
# Edit inside protected regions only.
"""The mission as its model describes it."""

from mrsfi_runtime.api import (
    Area,
    AvoidCollision,
    Battery,
    Coordinates,
    GatherSamples,
    Goal,
    Message,
    MessageData,
    Mission,
    MotionSource,
    Obstacle,
    Patrol,
    Robot,
    Sensor,
    Server,
    StayWithinMissionArea,
    SufficientEnergy,
    Visit,
)


def load_mission() -> Mission:
    """Return the mission."""
    return Mission(
        name="Fleet of 30",
        duration=300,
        area=Area(
            id="whole",
            radius=739.4112549695428,
            center=Coordinates(x=0.0, y=0.0, z=0.0),
        ),
        robots=(
            Robot(
                id="q0r0",
                name="robot 0 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-320.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r0_gps_position",
                        name="q0r0_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                    Sensor(
                        id="q0r0_temperature",
                        name="q0r0_temperature",
                        type="TEMPERATURE",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r0_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r0_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r1",
                name="robot 1 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-280.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r1_gps_position",
                        name="q0r1_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r1_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r1_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r2",
                name="robot 2 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-240.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r2_gps_position",
                        name="q0r2_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r2_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r2_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r3",
                name="robot 3 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-200.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r3_gps_position",
                        name="q0r3_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r3_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r3_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r4",
                name="robot 4 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-160.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r4_gps_position",
                        name="q0r4_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r4_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r4_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r5",
                name="robot 5 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-320.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r5_gps_position",
                        name="q0r5_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r5_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r5_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r6",
                name="robot 6 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-280.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r6_gps_position",
                        name="q0r6_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r6_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r6_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r7",
                name="robot 7 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-240.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r7_gps_position",
                        name="q0r7_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r7_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r7_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r8",
                name="robot 8 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-200.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r8_gps_position",
                        name="q0r8_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r8_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r8_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q0r9",
                name="robot 9 of squad 0",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-160.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q0r9_gps_position",
                        name="q0r9_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q0r9_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q0r9_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r0",
                name="robot 0 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=160.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r0_gps_position",
                        name="q1r0_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                    Sensor(
                        id="q1r0_temperature",
                        name="q1r0_temperature",
                        type="TEMPERATURE",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r0_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r0_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r1",
                name="robot 1 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=200.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r1_gps_position",
                        name="q1r1_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r1_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r1_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r2",
                name="robot 2 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=240.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r2_gps_position",
                        name="q1r2_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r2_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r2_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r3",
                name="robot 3 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=280.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r3_gps_position",
                        name="q1r3_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r3_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r3_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r4",
                name="robot 4 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=320.0, y=-160.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r4_gps_position",
                        name="q1r4_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r4_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r4_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r5",
                name="robot 5 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=160.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r5_gps_position",
                        name="q1r5_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r5_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r5_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r6",
                name="robot 6 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=200.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r6_gps_position",
                        name="q1r6_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r6_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r6_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r7",
                name="robot 7 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=240.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r7_gps_position",
                        name="q1r7_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r7_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r7_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r8",
                name="robot 8 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=280.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r8_gps_position",
                        name="q1r8_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r8_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r8_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q1r9",
                name="robot 9 of squad 1",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=320.0, y=-200.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q1r9_gps_position",
                        name="q1r9_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q1r9_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q1r9_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r0",
                name="robot 0 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-320.0, y=320.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r0_gps_position",
                        name="q2r0_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                    Sensor(
                        id="q2r0_temperature",
                        name="q2r0_temperature",
                        type="TEMPERATURE",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r0_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r0_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r1",
                name="robot 1 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-280.0, y=320.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r1_gps_position",
                        name="q2r1_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r1_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r1_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r2",
                name="robot 2 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-240.0, y=320.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r2_gps_position",
                        name="q2r2_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r2_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r2_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r3",
                name="robot 3 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-200.0, y=320.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r3_gps_position",
                        name="q2r3_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r3_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r3_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r4",
                name="robot 4 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-160.0, y=320.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r4_gps_position",
                        name="q2r4_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r4_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r4_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r5",
                name="robot 5 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-320.0, y=280.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r5_gps_position",
                        name="q2r5_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r5_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r5_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r6",
                name="robot 6 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-280.0, y=280.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r6_gps_position",
                        name="q2r6_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r6_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r6_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r7",
                name="robot 7 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-240.0, y=280.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r7_gps_position",
                        name="q2r7_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r7_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r7_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r8",
                name="robot 8 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-200.0, y=280.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r8_gps_position",
                        name="q2r8_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r8_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r8_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
            Robot(
                id="q2r9",
                name="robot 9 of squad 2",
                speed=1.5,
                max_speed=5.0,
                position=Coordinates(x=-160.0, y=280.0, z=0.0),
                sensors=(
                    Sensor(
                        id="q2r9_gps_position",
                        name="q2r9_gps_position",
                        type="GPS_POSITION",
                        energy_per_sample=0.0,
                        samples_per_second=1,
                    ),
                ),
                batteries=(
                    Battery(
                        id="q2r9_battery",
                        name="battery",
                        total_energy=1485.0000000000002,
                    ),
                ),
                motion_sources=(
                    MotionSource(
                        id="q2r9_motor",
                        name="motor",
                        energy_per_distance_unit=3.0,
                    ),
                ),
            ),
        ),
        servers=(
            Server(
                id="base",
                name="Base",
            ),
        ),
        obstacles=(
            Obstacle(
                id="q0_reef",
                area=Area(
                    id="q0_reef_area",
                    radius=10.0,
                    center=Coordinates(x=-240.0, y=-240.0, z=0.0),
                ),
            ),
            Obstacle(
                id="q1_reef",
                area=Area(
                    id="q1_reef_area",
                    radius=10.0,
                    center=Coordinates(x=240.0, y=-240.0, z=0.0),
                ),
            ),
            Obstacle(
                id="q2_reef",
                area=Area(
                    id="q2_reef_area",
                    radius=10.0,
                    center=Coordinates(x=-240.0, y=240.0, z=0.0),
                ),
            ),
        ),
        goals=(
            Goal(
                id="clear",
                name="AvoidCollision",
                members=(
                    "q0r0",
                    "q0r1",
                    "q0r2",
                    "q0r3",
                    "q0r4",
                    "q0r5",
                    "q0r6",
                    "q0r7",
                    "q0r8",
                    "q0r9",
                    "q1r0",
                    "q1r1",
                    "q1r2",
                    "q1r3",
                    "q1r4",
                    "q1r5",
                    "q1r6",
                    "q1r7",
                    "q1r8",
                    "q1r9",
                    "q2r0",
                    "q2r1",
                    "q2r2",
                    "q2r3",
                    "q2r4",
                    "q2r5",
                    "q2r6",
                    "q2r7",
                    "q2r8",
                    "q2r9",
                ),
                task=AvoidCollision(
                    robots=(
                        "q0r0",
                        "q0r1",
                        "q0r2",
                        "q0r3",
                        "q0r4",
                        "q0r5",
                        "q0r6",
                        "q0r7",
                        "q0r8",
                        "q0r9",
                        "q1r0",
                        "q1r1",
                        "q1r2",
                        "q1r3",
                        "q1r4",
                        "q1r5",
                        "q1r6",
                        "q1r7",
                        "q1r8",
                        "q1r9",
                        "q2r0",
                        "q2r1",
                        "q2r2",
                        "q2r3",
                        "q2r4",
                        "q2r5",
                        "q2r6",
                        "q2r7",
                        "q2r8",
                        "q2r9",
                    ),
                    obstacles=("q0_reef", "q1_reef", "q2_reef"),
                ),
                messages=(
                    Message(
                        id="clear_q0r0",
                        sender="q0r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r1",
                        sender="q0r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r2",
                        sender="q0r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r3",
                        sender="q0r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r4",
                        sender="q0r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r5",
                        sender="q0r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r6",
                        sender="q0r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r7",
                        sender="q0r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r8",
                        sender="q0r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q0r9",
                        sender="q0r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r0",
                        sender="q1r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r1",
                        sender="q1r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r2",
                        sender="q1r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r3",
                        sender="q1r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r4",
                        sender="q1r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r5",
                        sender="q1r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r6",
                        sender="q1r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r7",
                        sender="q1r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r8",
                        sender="q1r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q1r9",
                        sender="q1r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r0",
                        sender="q2r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r1",
                        sender="q2r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r2",
                        sender="q2r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r3",
                        sender="q2r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r4",
                        sender="q2r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r5",
                        sender="q2r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r6",
                        sender="q2r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r7",
                        sender="q2r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r8",
                        sender="q2r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="clear_q2r9",
                        sender="q2r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="within",
                name="StayWithinMissionArea",
                members=(
                    "q0r0",
                    "q0r1",
                    "q0r2",
                    "q0r3",
                    "q0r4",
                    "q0r5",
                    "q0r6",
                    "q0r7",
                    "q0r8",
                    "q0r9",
                    "q1r0",
                    "q1r1",
                    "q1r2",
                    "q1r3",
                    "q1r4",
                    "q1r5",
                    "q1r6",
                    "q1r7",
                    "q1r8",
                    "q1r9",
                    "q2r0",
                    "q2r1",
                    "q2r2",
                    "q2r3",
                    "q2r4",
                    "q2r5",
                    "q2r6",
                    "q2r7",
                    "q2r8",
                    "q2r9",
                ),
                task=StayWithinMissionArea(),
            ),
            Goal(
                id="energy",
                name="SufficientEnergy",
                members=(
                    "q0r0",
                    "q0r1",
                    "q0r2",
                    "q0r3",
                    "q0r4",
                    "q0r5",
                    "q0r6",
                    "q0r7",
                    "q0r8",
                    "q0r9",
                    "q1r0",
                    "q1r1",
                    "q1r2",
                    "q1r3",
                    "q1r4",
                    "q1r5",
                    "q1r6",
                    "q1r7",
                    "q1r8",
                    "q1r9",
                    "q2r0",
                    "q2r1",
                    "q2r2",
                    "q2r3",
                    "q2r4",
                    "q2r5",
                    "q2r6",
                    "q2r7",
                    "q2r8",
                    "q2r9",
                ),
                task=SufficientEnergy(),
                messages=(
                    Message(
                        id="energy_q0r0",
                        sender="q0r0",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r1",
                        sender="q0r1",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r2",
                        sender="q0r2",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r3",
                        sender="q0r3",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r4",
                        sender="q0r4",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r5",
                        sender="q0r5",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r6",
                        sender="q0r6",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r7",
                        sender="q0r7",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r8",
                        sender="q0r8",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q0r9",
                        sender="q0r9",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r0",
                        sender="q1r0",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r1",
                        sender="q1r1",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r2",
                        sender="q1r2",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r3",
                        sender="q1r3",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r4",
                        sender="q1r4",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r5",
                        sender="q1r5",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r6",
                        sender="q1r6",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r7",
                        sender="q1r7",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r8",
                        sender="q1r8",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q1r9",
                        sender="q1r9",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r0",
                        sender="q2r0",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r1",
                        sender="q2r1",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r2",
                        sender="q2r2",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r3",
                        sender="q2r3",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r4",
                        sender="q2r4",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r5",
                        sender="q2r5",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r6",
                        sender="q2r6",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r7",
                        sender="q2r7",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r8",
                        sender="q2r8",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                    Message(
                        id="energy_q2r9",
                        sender="q2r9",
                        receiver="base",
                        body=(
                            MessageData(name="POSITION", type="Coordinates"),
                            MessageData(name="SPEED", type="Int"),
                            MessageData(name="ENERGY", type="Double"),
                        ),
                    ),
                ),
            ),
            Goal(
                id="q0_buoy",
                name="Buoy of squad 0",
                members=("q0r1",),
                task=Visit(
                    coordinates=Coordinates(x=-240.0, y=-120.0, z=0.0),
                    tolerance=15.0,
                    deadline=200,
                ),
                messages=(
                    Message(
                        id="q0_buoy_q0r1",
                        sender="q0r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q0_rounds",
                name="Rounds of squad 0",
                members=(
                    "q0r0",
                    "q0r1",
                    "q0r2",
                    "q0r3",
                    "q0r4",
                    "q0r5",
                    "q0r6",
                    "q0r7",
                    "q0r8",
                    "q0r9",
                ),
                task=Patrol(
                    area=Area(
                        id="q0_rounds_area",
                        radius=200.0,
                        center=Coordinates(x=-240.0, y=-240.0, z=0.0),
                    ),
                    period=20,
                ),
                messages=(
                    Message(
                        id="q0_rounds_q0r0",
                        sender="q0r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r1",
                        sender="q0r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r2",
                        sender="q0r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r3",
                        sender="q0r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r4",
                        sender="q0r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r5",
                        sender="q0r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r6",
                        sender="q0r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r7",
                        sender="q0r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r8",
                        sender="q0r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q0_rounds_q0r9",
                        sender="q0r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q0_samples",
                name="Samples of squad 0",
                members=("q0r0",),
                area=Area(
                    id="q0_samples_area",
                    radius=240.0,
                    center=Coordinates(x=-240.0, y=-240.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=150, sensor="q0r0_temperature"),
                messages=(
                    Message(
                        id="q0_samples_q0r0",
                        sender="q0r0",
                        receiver="base",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="q1_buoy",
                name="Buoy of squad 1",
                members=("q1r1",),
                task=Visit(
                    coordinates=Coordinates(x=240.0, y=-120.0, z=0.0),
                    tolerance=15.0,
                    deadline=200,
                ),
                messages=(
                    Message(
                        id="q1_buoy_q1r1",
                        sender="q1r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q1_rounds",
                name="Rounds of squad 1",
                members=(
                    "q1r0",
                    "q1r1",
                    "q1r2",
                    "q1r3",
                    "q1r4",
                    "q1r5",
                    "q1r6",
                    "q1r7",
                    "q1r8",
                    "q1r9",
                ),
                task=Patrol(
                    area=Area(
                        id="q1_rounds_area",
                        radius=200.0,
                        center=Coordinates(x=240.0, y=-240.0, z=0.0),
                    ),
                    period=20,
                ),
                messages=(
                    Message(
                        id="q1_rounds_q1r0",
                        sender="q1r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r1",
                        sender="q1r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r2",
                        sender="q1r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r3",
                        sender="q1r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r4",
                        sender="q1r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r5",
                        sender="q1r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r6",
                        sender="q1r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r7",
                        sender="q1r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r8",
                        sender="q1r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q1_rounds_q1r9",
                        sender="q1r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q1_samples",
                name="Samples of squad 1",
                members=("q1r0",),
                area=Area(
                    id="q1_samples_area",
                    radius=240.0,
                    center=Coordinates(x=240.0, y=-240.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=150, sensor="q1r0_temperature"),
                messages=(
                    Message(
                        id="q1_samples_q1r0",
                        sender="q1r0",
                        receiver="base",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
            Goal(
                id="q2_buoy",
                name="Buoy of squad 2",
                members=("q2r1",),
                task=Visit(
                    coordinates=Coordinates(x=-240.0, y=360.0, z=0.0),
                    tolerance=15.0,
                    deadline=200,
                ),
                messages=(
                    Message(
                        id="q2_buoy_q2r1",
                        sender="q2r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q2_rounds",
                name="Rounds of squad 2",
                members=(
                    "q2r0",
                    "q2r1",
                    "q2r2",
                    "q2r3",
                    "q2r4",
                    "q2r5",
                    "q2r6",
                    "q2r7",
                    "q2r8",
                    "q2r9",
                ),
                task=Patrol(
                    area=Area(
                        id="q2_rounds_area",
                        radius=200.0,
                        center=Coordinates(x=-240.0, y=240.0, z=0.0),
                    ),
                    period=20,
                ),
                messages=(
                    Message(
                        id="q2_rounds_q2r0",
                        sender="q2r0",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r1",
                        sender="q2r1",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r2",
                        sender="q2r2",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r3",
                        sender="q2r3",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r4",
                        sender="q2r4",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r5",
                        sender="q2r5",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r6",
                        sender="q2r6",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r7",
                        sender="q2r7",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r8",
                        sender="q2r8",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                    Message(
                        id="q2_rounds_q2r9",
                        sender="q2r9",
                        receiver="base",
                        body=(MessageData(name="POSITION", type="Coordinates"),),
                    ),
                ),
            ),
            Goal(
                id="q2_samples",
                name="Samples of squad 2",
                members=("q2r0",),
                area=Area(
                    id="q2_samples_area",
                    radius=240.0,
                    center=Coordinates(x=-240.0, y=240.0, z=0.0),
                ),
                task=GatherSamples(target_sample_number=150, sensor="q2r0_temperature"),
                messages=(
                    Message(
                        id="q2_samples_q2r0",
                        sender="q2r0",
                        receiver="base",
                        body=(MessageData(name="TEMPERATURE", type="Int"),),
                    ),
                ),
            ),
        ),
    )
