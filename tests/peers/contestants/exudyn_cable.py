"""Exudyn: ANCF cable elements in the plane, a rigid body jointed to the last, generalised alpha at fixed steps.

Its curvature is by current length. Mass damping has no place in its elements; a matrix of its own puts it on.
"""

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (Cable2D, CoordinateConstraint, Force, GenericJoint, Gravity, MarkerBodyMass,
                                  MarkerBodyPosition, MarkerBodyRigid, MarkerNodeCoordinate, NodePointGround,
                                  ObjectGenericODE2, Point2DS1, Rigid2D, RigidBody2D, SensorBody)

from case import DURATION, RATE

NAME = "Exudyn"
TINY = 1e-9  # rotary inertia of the point mass, kg m^2: a body must have one


def settings(case):
    fine = [dict(elements=n, step=h) for n in (3, 4, 6, 8) for h in (1e-2, 5e-3, 2.5e-3, 1e-3)]
    return fine + [dict(elements=n, step=2.5e-3) for n in (16, 32, 64, 96, 128)]


def consistent_mass(case, elements):
    """Of one element, a cubic with slopes, which the damping needs as a matrix."""
    l = case.length / elements
    one = case.mass / elements / 420 * np.array([
        [156, 22 * l, 54, -13 * l], [22 * l, 4 * l * l, 13 * l, -3 * l * l],
        [54, 13 * l, 156, -22 * l], [-13 * l, -3 * l * l, -22 * l, 4 * l * l]])
    return np.kron(one, np.eye(2))


def prepare(case, elements, step):
    def run():
        mbs, sensor = built(case, elements)
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = DURATION
        settings.timeIntegration.numberOfSteps = round(DURATION / step)
        settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
        settings.timeIntegration.adaptiveStep = False
        settings.timeIntegration.verboseMode = 0
        settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse
        settings.solutionSettings.writeSolutionToFile = False
        settings.solutionSettings.sensorsWritePeriod = 1 / RATE
        settings.displayStatistics = False
        mbs.SolveDynamic(settings)
        data = mbs.GetSensorStoredData(sensor)
        times = np.arange(int(DURATION * RATE) + 1) / RATE
        if np.abs(data[:, 0] - np.round(data[:, 0] * RATE) / RATE).max() < 1e-9 and len(data) == len(times):
            return data[:, 1:3]
        from scipy.interpolate import CubicSpline  # steps that do not divide the sampling's
        return CubicSpline(data[:, 0], data[:, 1:3])(times)

    return run


def built(case, elements):
    mbs = exu.SystemContainer().AddSystem()
    l = case.length / elements
    nodes = [mbs.AddNode(Point2DS1(referenceCoordinates=[i * l, 0, 1, 0])) for i in range(elements + 1)]
    mass = consistent_mass(case, elements)
    nothing = np.zeros_like(mass)
    for i in range(elements):
        cable = mbs.AddObject(Cable2D(
            length=l, massPerLength=case.mass / case.length, nodeNumbers=nodes[i:i + 2],
            bendingStiffness=case.bending_stiffness, axialStiffness=case.axial_stiffness,
            bendingDamping=case.beta * case.bending_stiffness, axialDamping=case.beta * case.axial_stiffness))
        weight = mbs.AddMarker(MarkerBodyMass(bodyNumber=cable))
        mbs.AddLoad(Gravity(markerNumber=weight, loadVector=[0, -case.gravity, 0]))
        # One matrix of the whole rod would fill the Jacobian.
        mbs.AddObject(ObjectGenericODE2(nodeNumbers=nodes[i:i + 2], massMatrix=nothing, stiffnessMatrix=nothing,
                                        dampingMatrix=case.alpha * mass, forceVector=np.zeros(len(mass))))
    ground = mbs.AddNode(NodePointGround())
    wall = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=ground, coordinate=0))
    for k in (0, 1, 3):  # position, and the slope across; the slope along is free to stretch
        held = mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=k))
        mbs.AddObject(CoordinateConstraint(markerNumbers=[wall, held]))
    center = mbs.AddNode(Rigid2D(referenceCoordinates=[case.length + case.tip_offset, 0, 0]))
    body = mbs.AddObject(RigidBody2D(physicsMass=case.tip_mass, physicsInertia=TINY, nodeNumber=center))
    behind = mbs.AddMarker(MarkerBodyRigid(bodyNumber=body, localPosition=[-case.tip_offset, 0, 0]))
    end = mbs.AddMarker(MarkerBodyRigid(bodyNumber=cable, localPosition=[l, 0, 0]))
    mbs.AddObject(GenericJoint(markerNumbers=[end, behind], constrainedAxes=[1, 1, 0, 0, 0, 1]))
    weight = mbs.AddMarker(MarkerBodyPosition(bodyNumber=body))
    mbs.AddLoad(Force(markerNumber=weight, loadVector=[0, -case.gravity * case.tip_mass, 0]))
    mbs.AddObject(ObjectGenericODE2(nodeNumbers=[center], massMatrix=np.zeros((3, 3)), forceVector=np.zeros(3),
                                    stiffnessMatrix=np.zeros((3, 3)),
                                    dampingMatrix=case.alpha * case.tip_mass * np.diag([1.0, 1.0, 0.0])))
    position = exu.OutputVariableType.Position
    sensor = mbs.AddSensor(SensorBody(bodyNumber=body, storeInternal=True, outputVariableType=position))
    mbs.Assemble()
    return mbs, sensor
