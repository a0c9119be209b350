// The arm as tubes between its joints, by the same lengths that the cell plans with.
import { THREE } from "nicegui-scene";
import { matrixOf } from "cellctl-scene/parts.js";

const SETTLE_S = 0.12; // how fast the drawn arm follows what the robot last said
const STILL_RAD = 1e-4;

export class Arm {
  constructor(place, palette) {
    this.place = place;
    this.palette = palette;
    this.group = new THREE.Group();
    this.group.applyMatrix4(matrixOf(place.base));
    this.tubes = [
      [0.086, "arm"],
      [0.082, "joint"],
      [0.066, "arm"],
      [0.062, "joint"],
      [0.055, "arm"],
      [0.05, "joint"],
      [0.047, "arm"],
      [0.047, "joint"],
      [0.045, "arm"],
    ].map(([radius, kind]) => this.tube(radius, kind));
    this.tip = new THREE.Group();
    this.group.add(this.tip);
    this.tip.matrixAutoUpdate = false;
    const width = place.tool_width_m;
    const height = place.tool_height_m;
    const tool = new THREE.Mesh(
      new THREE.BoxGeometry(width * 0.8, width * 0.8, height * 0.9),
      palette.material("joint"),
    );
    tool.position.z = -place.pitch_m / 2 - height * 0.45;
    tool.castShadow = true;
    this.tip.add(tool);
    this.tool = matrixOf(place.tool).multiply(new THREE.Matrix4().makeTranslation(0, 0, place.pitch_m / 2));
    this.group.visible = false;
  }

  tube(radius, kind) {
    const group = new THREE.Group();
    const material = this.palette.material(kind);
    const body = new THREE.Mesh(new THREE.CylinderGeometry(radius, radius, 1, 28), material);
    const ends = [0, 1].map(() => new THREE.Mesh(new THREE.SphereGeometry(radius, 28, 18), material));
    for (const mesh of [body, ...ends]) mesh.castShadow = mesh.receiveShadow = true;
    group.add(body, ...ends);
    this.group.add(group);
    return { body, ends };
  }

  stretch({ body, ends }, from, to) {
    const way = to.clone().sub(from);
    const length = Math.max(way.length(), 1e-5);
    body.scale.y = length;
    body.position.copy(from).addScaledVector(way, 0.5);
    body.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    ends[0].position.copy(from);
    ends[1].position.copy(to);
  }

  // Returns whether something is to be drawn.
  wants(joints, atOnce) {
    if (joints.length !== 6) {
      this.group.visible = false;
      return true;
    }
    this.wanted = joints;
    if (!this.joints || atOnce) {
      this.joints = [...joints];
      this.bend();
    }
    this.group.visible = true;
    return true;
  }

  advance(passed) {
    if (!this.joints) return false;
    const left = this.joints.map((joint, i) => this.wanted[i] - joint);
    if (Math.max(...left.map(Math.abs)) < STILL_RAD) return false;
    const share = 1 - Math.exp(-passed / SETTLE_S);
    this.joints = this.joints.map((joint, i) => joint + share * left[i]);
    this.bend();
    return true;
  }

  bend() {
    const { d1, upper_arm: upper, forearm, d4, d5, d6, upper_aside: a, fore_aside: b } = this.place.arm;
    // Denavit-Hartenberg, from the foot to the flange.
    const rows = [
      [d1, 0, Math.PI / 2],
      [0, -upper, 0],
      [0, -forearm, 0],
      [d4, 0, Math.PI / 2],
      [d5, 0, -Math.PI / 2],
      [d6, 0, 0],
    ];
    const at = new THREE.Matrix4();
    const frames = rows.map(([d, length, twist], i) => {
      at.multiply(new THREE.Matrix4().makeRotationZ(this.joints[i]));
      at.multiply(new THREE.Matrix4().makeTranslation(length, 0, d));
      at.multiply(new THREE.Matrix4().makeRotationX(twist));
      return at.clone();
    });
    const [shoulder, elbow, wrist, first, second, flange] = frames.map((m) =>
      new THREE.Vector3().setFromMatrixPosition(m),
    );
    const aside = new THREE.Vector3().setFromMatrixColumn(frames[0], 2);
    const beside = (point, by) => point.clone().addScaledVector(aside, by);
    const points = [
      [new THREE.Vector3(0, 0, 0.02), shoulder],
      [shoulder, beside(shoulder, a)],
      [beside(shoulder, a), beside(elbow, a)],
      [beside(elbow, a), beside(elbow, b)],
      [beside(elbow, b), beside(wrist, b)],
      [beside(wrist, b), first],
      [first, second],
      [second, second.clone().lerp(flange, 0.5)],
      [second.clone().lerp(flange, 0.5), flange],
    ];
    points.forEach(([from, to], i) => this.stretch(this.tubes[i], from, to));
    this.tip.matrix.multiplyMatrices(frames[5], this.tool);
    this.tip.matrixWorldNeedsUpdate = true;
  }
}
