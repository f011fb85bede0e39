# SPDX-License-Identifier: Apache-2.0
"""Pick with a hand that lives in another physics engine: SAPIEN, which is PhysX.

Palpate knows nothing of it but what HandInSapien.step() returns: joints, torques, load and
contacts, with the noise of real sensors, of a hand whose links are 2 mm off its description.

usage: hand_in_sapien.py [--hand HAND] [--object NAME] [--trials N] [--seed N]

HAND: a model file, or a name of `palpate hand list`, as allegro after `palpate hand install
allegro`; without it a hand of three fingers.
"""

import argparse
import pathlib
import warnings

import numpy as np
import palpate
from palpate import sim

warnings.filterwarnings("ignore", "Failed to find")  # of Vulkan: nothing is drawn
import sapien  # noqa: E402
from sapien import physx  # noqa: E402

THREE_FINGERS = pathlib.Path(__file__).parents[1] / "hands" / "three_fingers.xml"
STEP, STEPS = 0.002, 5  # s of the physics, and how many a tick of 10 ms
SERVO_DAMPING = 0.01  # N m s/rad, of the fingers' controllers
SLIDE, HINGE = (4000, 253, 200), (200, 12.6, 50)  # stiffness, damping, limit of the mount's drives
MOUNT = 4.0, [0.02] * 3  # kg, kg m^2, of hand and wrist, for which the drives are damped
BASE = [("prismatic", axis, SLIDE) for axis in np.eye(3)]  # x, y, z; then yaw, pitch, roll
BASE += [("revolute_unwrapped", axis, HINGE) for axis in np.eye(3)[::-1]]
SOFT = 0.01  # m, radius of a fingertip's contact patch: it resists turning, as soft rubber does
HAND = [1, 1, 1, 0]  # collision groups: what shares a bit of the third lets one another through
NOISE = {"point": 0.001, "normal": np.radians(10), "force": 0.05, "joint": np.radians(0.5),
         "load": 0.02, "torque": 0.0005, "link": 0.002}  # fmt: skip


def pose(T):
    return sapien.Pose(np.asarray(T, np.float32))


def along_x(axis, p=(0, 0, 0)):
    """A frame at p whose x axis is `axis`: joints turn about it, capsules lie along it."""
    x = np.asarray(axis) / np.linalg.norm(axis)
    y = np.cross(np.eye(3)[np.argmin(np.abs(x))], x)
    y /= np.linalg.norm(y)
    T = np.eye(4)
    T[:3, :4] = np.column_stack([x, y, np.cross(x, y), p])
    return T


def add_shape(link, shape, T, density):
    shape.local_pose, shape.density = pose(T), density
    shape.set_collision_groups(HAND)
    link.attach(shape)


class HandInSapien(palpate.Hand):
    def __init__(self, description, model, seed):
        self.random = np.random.default_rng(seed)
        believed = description.with_perturbed_links(NOISE["link"], seed=seed)
        super().__init__(believed)  # what the pick believes; the physics has the true links
        physx.set_shape_config(contact_offset=0.002)
        physx.set_body_config(solver_position_iterations=30, sleep_threshold=0)
        physx.set_scene_config(enable_pcm=False)  # it can miss a capsule that is 7 mm in a hull
        self.system = physx.PhysxCpuSystem()
        self.scene = sapien.Scene([self.system])
        self.scene.timestep = STEP
        self.ticks = 0
        self.add_table()
        self.object = self.add_object(model.object)
        self.add_hand(description)
        self.place_hand(sim.waiting_command(description))

    def add_table(self):
        entity, body = sapien.Entity(), physx.PhysxRigidStaticComponent()
        table = physx.PhysxCollisionShapePlane(physx.PhysxMaterial(0.2, 0.2, 0))
        table.local_pose = pose(along_x([0, 0, 1]))
        body.attach(table)
        entity.add_component(body)
        self.scene.add_entity(entity)

    def add_object(self, known):
        """The convex hull of the object at rest, within 2 cm of the origin."""
        rests = known.stable_poses
        shares = np.array([rest.probability for rest in rests])
        rest = rests[self.random.choice(len(rests), p=shares / shares.sum())]
        c, s = np.cos(yaw := self.random.uniform(-np.pi, np.pi)), np.sin(yaw)
        T = np.eye(4)
        T[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ rest.R_table_object
        T[:3, 3] = [*self.random.uniform(-0.02, 0.02, 2), rest.height + 0.0005]
        entity, body = sapien.Entity(), physx.PhysxRigidDynamicComponent()
        rubber = physx.PhysxMaterial(0.8, 0.8, 0)
        hull = physx.PhysxCollisionShapeConvexMesh(known.mesh.vertices, [1, 1, 1], rubber)
        body.attach(hull)
        body.mass = known.mass
        entity.add_component(body)
        entity.pose = pose(T)
        self.scene.add_entity(entity)
        return body

    def add_joint(self, parent, kind, T_parent_link, axis, limits, drive, armature):
        entity, link = sapien.Entity(), physx.PhysxArticulationLinkComponent(parent)
        entity.add_component(link)
        link.disable_gravity = True
        link.mass, link.inertia = 0.02, [1e-5] * 3
        joint, frame = link.joint, along_x(axis)
        joint.type = kind
        joint.pose_in_parent, joint.pose_in_child = pose(T_parent_link @ frame), pose(frame)
        if kind != "fixed":
            joint.limits = [limits]
            stiffness, damping, limit = drive
            joint.set_drive_properties(stiffness, damping, limit, "force")
            joint.armature = [armature]
        self.entities.append(entity)
        return link

    def add_hand(self, description):
        root = sapien.Entity()
        link = physx.PhysxArticulationLinkComponent(None)
        root.add_component(link)
        link.joint.type = "fixed"
        self.entities = [root]
        for kind, axis, drive in BASE:
            link = self.add_joint(link, kind, np.eye(4), axis, [-10, 10], drive, 0.01)
        mount, links = link, []
        mount.mass, mount.inertia = MOUNT
        servos = {a.joints[0][0]: a for a in description.actuators}  # one joint each: no couplings
        for one in description.links:
            parent = mount if one.parent < 0 else links[one.parent]
            if one.joint < 0:
                links.append(self.add_joint(parent, "fixed", one.T_parent_link, [1, 0, 0], 0, 0, 0))
                continue
            servo, limits = servos[one.joint], description.joints[one.joint].range
            drive = (servo.stiffness, servo.damping + SERVO_DAMPING, servo.max_torque)
            links.append(self.add_joint(parent, "revolute", one.T_parent_link, one.axis, limits,
                                        drive, servo.armature))  # fmt: skip
        self.add_surface(description, links)
        for entity in self.entities:
            self.scene.add_entity(entity)
        self.hand = mount.articulation
        moving = [entity.components[0].joint for entity in self.entities]
        self.joints = [joint for joint in moving if joint.dof]  # mount, then in the hand's order
        self.slots = [self.hand.active_joints.index(joint) for joint in self.joints]
        self.order = [6 + a.joints[0][0] for a in description.actuators]
        self.stiffness = np.array([a.stiffness for a in description.actuators])

    def add_surface(self, description, links):
        rubber = physx.PhysxMaterial(0.8, 0.8, 0)
        self.tips = [links[finger.link] for finger in description.fingers]
        for finger, link in zip(description.fingers, self.tips):
            a, b, radius = finger.tip
            capsule = physx.PhysxCollisionShapeCapsule(radius, np.linalg.norm(b - a) / 2, rubber)
            capsule.patch_radius = capsule.min_patch_radius = SOFT
            add_shape(link, capsule, along_x(b - a, (a + b) / 2), 0)
        for index, center, radius in description.spheres:
            if links[index] not in self.tips:
                ball = physx.PhysxCollisionShapeSphere(radius, rubber)
                add_shape(links[index], ball, along_x([1, 0, 0], center), 0)

    def targets(self, command):
        q = np.zeros(len(self.joints), np.float32)
        q[:6] = [*command.mount_xyz, *command.mount_ypr]
        q[self.order] = command.positions
        return q

    def place_hand(self, command):
        self.command(command)
        self.hand.qpos = self.wanted[np.argsort(self.slots)]

    def command(self, command):
        self.wanted = self.targets(command)
        for joint, target in zip(self.joints, self.wanted):
            joint.set_drive_target(target)

    def step(self, command):
        """Applies the command for one tick of 10 ms and returns what was sensed at its end."""
        self.command(command)
        load = np.zeros(3)  # the mean of the tick, as a load cell gives it
        for _ in range(STEPS):
            self.system.step()
            q, v = self.hand.qpos[self.slots], self.hand.qvel[self.slots]
            load += (SLIDE[0] * (self.wanted - q)[:3] - SLIDE[1] * v[:3]) / STEPS
        self.ticks += 1
        noisy = self.random.normal
        torques = self.stiffness * (self.wanted - q)[self.order] - SERVO_DAMPING * v[self.order]
        return palpate.HandReading(
            0.01 * self.ticks, noisy(q[6:], NOISE["joint"]), noisy(torques, NOISE["torque"]),
            q[:3], q[3:6], noisy(load, NOISE["load"]), self.contacts(),
        )  # fmt: skip

    def contacts(self):
        contacts = [[] for _ in self.tips]
        for contact in self.system.get_contacts():
            for side in range(2):
                if contact.bodies[side] in self.tips:
                    finger = self.tips.index(contact.bodies[side])
                    sign = 1 if side == 0 else -1  # normal and impulse are of the first body
                    points = [self.sensed(point, finger, sign) for point in contact.points]
                    contacts[finger] += filter(None, points)
        return contacts

    def sensed(self, point, finger, sign):
        """The contact as a noisy sensor gives it; None where it drowns in the noise."""
        T = self.tips[finger].entity_pose.to_transformation_matrix()
        R, n = T[:3, :3].T, sign * point.normal
        f = R @ (-sign * point.impulse / STEP)
        if not f.any():
            return None
        p = R @ (point.position - T[:3, 3]) + self.random.normal(0, NOISE["point"], 3)
        tilt = self.random.normal(0, NOISE["normal"], 3)
        n = R @ n
        n = n + tilt - n * (n @ tilt)
        n /= np.linalg.norm(n)
        f = f + self.random.normal(0, NOISE["force"], 3)
        return palpate.TipContact(p, n, f) if f @ n < 0 else None


def trial(description, model, seed):
    """One pick; whether it was lifted and its pose right, by what the engine alone knows."""
    hand = HandInSapien(description, model, seed)
    result = sim.pick(model, hand, seed=seed)
    truth = hand.object.entity_pose.to_transformation_matrix()
    lowest = (model.object.mesh.vertices @ truth[2, :3]).min() + truth[2, 3]
    lifted, error = bool(result.held and lowest > 0.05), result.posterior.error(truth)
    right = lifted and error is not None and error[0] < np.radians(5) and error[1] < 0.01
    off = f", {np.degrees(error[0]):.1f} deg {1e3 * error[1]:.1f} mm off" if error else ""
    print(f"seed {seed}: {result}{', lifted' if lifted else ''}{off}", flush=True)
    return lifted, right


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hand", default=str(THREE_FINGERS))
    parser.add_argument("--object", default="box")
    parser.add_argument("--trials", type=int, default=1)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    known = palpate.ObjectModel(palpate.load_known_object(given.object))
    described = sim.load_hand(given.hand)
    done = [trial(described, known, given.seed + i) for i in range(given.trials)]
    lifts, poses = np.sum(done, axis=0)
    print(f"{lifts} of {given.trials} lifted, {poses} with the right pose")
