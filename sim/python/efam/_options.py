"""Options by their names, and keys of scenarios and experiments: for editors and mypy.

Generated from those that the program accepts; do not edit. To write it anew:

    EFAM_WRITE_DOCS=1 sim/python/check
"""

from typing import Any, SupportsFloat, TypedDict, Union

Quantity = Union[str, SupportsFloat]

Options = TypedDict(
    "Options",
    {
        "payload": Quantity,  # kg
        "payload_center": Quantity,  # m
        "payload_inertia": Quantity,  # kg m^2
        "frontal_area": Quantity,  # m^2
        "angle": Quantity,  # rad
        "duration": Quantity,  # s
        "muscle": Any,
        "pressure": Any,
        "name": Any,
        "rod": Any,
        "release": Any,
        "run": Any,
        "integrator": Any,
        "effects": Any,
        "laws": Any,
        "calibration": Any,
        "muscle.name": Any,
        "muscle.file": Any,
        "muscle.text": Any,
        "muscle.pressure": Any,
        "muscle.stiffness": Any,
        "muscle.extrapolation": Any,
        "muscle.mass": Any,
        "rod.nodes": Any,
        "rod.scheme": Any,
        "rod.root": Any,
        "rod.base_angle": Quantity,  # rad
        "rod.tip": Quantity,  # m
        "release.angle": Quantity,  # rad
        "release.angular_velocity": Quantity,  # rad/s
        "release.from": Any,
        "release.by": Any,
        "release.posture": Any,
        "release.nodes": Any,
        "release.hold": Any,
        "release.history": Any,
        "run.duration": Quantity,  # s
        "run.rate": Quantity,  # Hz
        "run.accuracy": Quantity,  # m
        "integrator.method": Any,
        "integrator.tolerance": Any,
        "integrator.most_steps": Any,
        "integrator.fixed_step": Quantity,  # s
        "rod.length": Quantity,  # m
        "rod.mass": Quantity,  # kg
        "rod.bending_stiffness": Quantity,  # N m^2
        "rod.axial_stiffness": Quantity,  # N
        "rod.diameter": Quantity,  # m
        "rod.pressure": Quantity,  # Pa
        "effects.gravity.acceleration": Quantity,  # m/s^2
        "effects.end_fitting.mass": Quantity,  # kg
        "effects.end_fitting.center_of_mass": Quantity,  # m
        "effects.end_fitting.rotary_inertia": Quantity,  # kg m^2
        "effects.payload.mass": Quantity,  # kg
        "effects.payload.center_of_mass": Quantity,  # m
        "effects.payload.rotary_inertia": Quantity,  # kg m^2
        "effects.payload.offset": Quantity,  # m
        "effects.rayleigh_mass.alpha": Quantity,  # 1/s
        "effects.rayleigh_stiffness.beta": Quantity,  # s
        "effects.tip_load.force_x": Quantity,  # N
        "effects.tip_load.force_z": Quantity,  # N
        "effects.tip_load.moment": Quantity,  # N m
        "effects.tip_hold.held": Quantity,  # dimensionless
        "effects.tip_hold.force_x": Quantity,  # N
        "effects.tip_hold.force_z": Quantity,  # N
        "effects.tip_hold.moment": Quantity,  # N m
        "effects.tip_hold.rate_x": Quantity,  # N/s
        "effects.tip_hold.rate_z": Quantity,  # N/s
        "effects.tip_hold.rate_moment": Quantity,  # N m/s
        "effects.air_drag.drag_coefficient": Quantity,  # dimensionless
        "effects.air_drag.air_density": Quantity,  # kg/m^3
        "effects.viscoelastic.branch_stiffness": Quantity,  # dimensionless
        "effects.viscoelastic.relaxation_time": Quantity,  # s
        "effects.clamp_compliance.compliance": Quantity,  # rad/(N m)
        "effects.tip_drag.drag_area": Quantity,  # m^2
        "effects.tip_drag.air_density": Quantity,  # kg/m^3
        "effects.linear_drag.drag_per_length": Quantity,  # N s/m^2
        "effects.braid_friction.friction_moment": Quantity,  # N m
        "effects.braid_friction.creep_rate": Quantity,  # 1/(m s)
        "effects.friction_over_pressure.friction_moment": Quantity,  # N m
        "effects.friction_over_pressure.creep_rate": Quantity,  # 1/(m s)
        "effects.friction_over_pressure.reference_pressure": Quantity,  # Pa
        "effects.hysteresis.loss_coefficient": Quantity,  # dimensionless
        "effects.hysteresis.creep_rate": Quantity,  # 1/(m s)
        "effects.dahl.friction_moment": Quantity,  # N m
        "effects.dahl.yield_curvature": Quantity,  # 1/m
        "effects.dahl.creep_rate": Quantity,  # 1/(m s)
        "effects.dahl.exponent": Quantity,  # dimensionless
        "effects.dahl.loop_shape": Quantity,  # dimensionless
        "effects.creep.creep_stiffness": Quantity,  # dimensionless
        "effects.creep.creep_time": Quantity,  # s
        "effects.relaxation.relaxing_stiffness": Quantity,  # dimensionless
        "effects.relaxation.shortest_time": Quantity,  # s
        "effects.relaxation.longest_time": Quantity,  # s
        "effects.structural_damping.loss_factor": Quantity,  # dimensionless
        "effects.structural_damping.middle_frequency": Quantity,  # Hz
        "effects.cubic_stiffness.coefficient": Quantity,  # m^2
        "effects.quadratic_stiffness.coefficient": Quantity,  # m
        "effects.stiffness_taper.taper": Quantity,  # dimensionless
        "effects.clamp_friction.friction_moment": Quantity,  # N m
        "effects.clamp_friction.grip_length": Quantity,  # m
        "effects.clamp_friction.creep_rate": Quantity,  # 1/(m s)
        "effects.hose.stiffness": Quantity,  # N/m
        "effects.hose.damping_time": Quantity,  # s
        "effects.hose.anchor_x": Quantity,  # m
        "effects.hose.anchor_z": Quantity,  # m
        "effects.tip_mass.mass": Quantity,  # kg
        "effects.tip_mass.distance": Quantity,  # m
        "effects.tip_mass.weight": Quantity,  # dimensionless
        "effects.tip_inertia.rotary_inertia": Quantity,  # kg m^2
        "effects.axial_compliance.compliance": Quantity,  # 1/N
        "effects.hand_release.force": Quantity,  # N
        "effects.hand_release.release_time": Quantity,  # s
        "effects.stiffness_drift.rate": Quantity,  # 1/s
        "effects.release_drift.share": Quantity,  # dimensionless
        "effects.strain_rate_cubed.coefficient": Quantity,  # m^2 s^3
        "effects.initial_velocity.angular_velocity": Quantity,  # rad/s
        "effects.set_curvature.natural_curvature": Quantity,  # 1/m
        "effects.set_curvature.curvature_over_pressure": Quantity,  # 1/(m Pa)
        "effects.set_curvature.taper": Quantity,  # 1/m
        "effects.damping_over_pressure.stiffness_time": Quantity,  # s
        "effects.damping_over_pressure.mass_rate": Quantity,  # 1/s
        "effects.damping_over_pressure.reference_pressure": Quantity,  # Pa
        "effects.tip_offset.distance": Quantity,  # m
        "effects.added_mass.mass_per_length": Quantity,  # kg/m
        "effects.enclosed_air.inner_diameter": Quantity,  # m
        "effects.pressure_volume.stiffening": Quantity,  # m^2
        "effects.latent_moment.constant": Quantity,  # 1/m
        "effects.latent_moment.linear": Quantity,  # dimensionless
        "effects.latent_moment.square": Quantity,  # m
        "effects.latent_moment.cube": Quantity,  # m^2
        "effects.latent_moment.rate_square": Quantity,  # s^2 m
        "effects.latent_moment.rate_sign": Quantity,  # 1/m
        "effects.latent_moment.square_rate": Quantity,  # m^2 s
        "effects.latent_moment.drift": Quantity,  # 1/(m s)
        "effects.pressure_line.time_constant": Quantity,  # s
        "effects.pressure_line.dead_time": Quantity,  # s
        "effects.pressure_line.rate_limit": Quantity,  # Pa/s
        "effects.marker_offset.across": Quantity,  # m
        "effects.marker_offset.along": Quantity,  # m
        "effects.out_of_plane.lost_share": Quantity,  # dimensionless
        "effects.frame_tilt.angle": Quantity,  # rad
        "effects.scale.relative_error": Quantity,  # dimensionless
        "effects.clock.rate_error": Quantity,  # dimensionless
        "effects.clock.offset": Quantity,  # s
    },
    total=False,
)

ExperimentOptions = TypedDict(
    "ExperimentOptions",
    {
        "name": Any,
        "muscle": Any,
        "rod": Any,
        "effects": Any,
        "laws": Any,
        "integrator": Any,
        "recording": Any,
        "calibrate": Any,
        "diagnose": Any,
    },
    total=False,
)
