// Parts, as what they are: cuboctahedra that touch at their square faces; and what does not move.
import { THREE } from "nicegui-scene";

const BELT_M = 1.05; // as much of the belt as is shown
const ELBOW_M = 0.2; // how far to a side of its foot the arm's elbow mostly is

export function partGeometry(pitch) {
  const h = pitch / 2;
  const corners = [];
  for (const a of [-h, h]) for (const b of [-h, h]) corners.push([a, b, 0], [a, 0, b], [0, a, b]);
  const at = corners.map((corner) => new THREE.Vector3(...corner));
  const planes = [];
  for (const s of [-1, 1]) for (const axis of [0, 1, 2]) {
    const normal = new THREE.Vector3().setComponent(axis, s);
    planes.push([normal, (p) => Math.abs(p.getComponent(axis) - s * h) < 1e-9]);
  }
  for (const x of [-1, 1]) for (const y of [-1, 1]) for (const z of [-1, 1]) {
    const normal = new THREE.Vector3(x, y, z);
    planes.push([normal, (p) => Math.abs(p.dot(normal) - 2 * h) < 1e-9]);
  }
  const triangles = [];
  const lines = [];
  for (const [normal, holds] of planes) {
    const face = at.filter(holds);
    const middle = face.reduce((sum, p) => sum.add(p), new THREE.Vector3()).divideScalar(face.length);
    const first = face[0].clone().sub(middle).normalize();
    const second = normal.clone().normalize().cross(first);
    const turn = (p) => {
      const from = p.clone().sub(middle);
      return Math.atan2(from.dot(second), from.dot(first));
    };
    face.sort((p, q) => turn(p) - turn(q));
    for (let i = 1; i + 1 < face.length; i++) triangles.push(face[0], face[i], face[i + 1]);
    if (face.length === 4) face.forEach((p, i) => lines.push(p, face[(i + 1) % 4]));
  }
  const solid = new THREE.BufferGeometry().setFromPoints(triangles);
  solid.computeVertexNormals();
  return { solid, edges: new THREE.BufferGeometry().setFromPoints(lines), pitch };
}

export class Part {
  constructor(geometry, palette, kind) {
    this.group = new THREE.Group();
    this.age = Infinity;
    const body = new THREE.Mesh(geometry.solid, palette.material(kind));
    body.castShadow = body.receiveShadow = true;
    this.group.add(body, new THREE.LineSegments(geometry.edges, palette.material("edge")));
  }
}

export function ghost(centres, geometry, palette) {
  const group = new THREE.Group();
  for (const centre of centres) {
    const lines = new THREE.LineSegments(geometry.edges, palette.material("planned"));
    lines.position.copy(centre);
    group.add(lines);
  }
  return group;
}

export function matrixOf(pose) {
  const turn = new THREE.Vector3(...pose.slice(3));
  const angle = turn.length();
  const rotation = new THREE.Matrix4();
  if (angle > 1e-9) rotation.makeRotationAxis(turn.divideScalar(angle), angle);
  return rotation.setPosition(...pose.slice(0, 3));
}

export class Furniture {
  constructor(place, palette) {
    this.palette = palette;
    this.place = place;
    this.group = new THREE.Group();
    this.workspace = matrixOf(place.workspace);
    const [nx, ny, nz] = place.grid;
    const p = place.pitch_m;
    this.middle = new THREE.Vector3((nx * p) / 2 - 0.08, (ny * p) / 2 - 0.3, nz * p * 0.95);
    this.middle.applyMatrix4(this.workspace);
    this.group.add(this.ground(), this.floor(nx, ny, p), this.pedestal(), this.belt());
  }

  // What a picture of the cell has to show: everything that stands here, and where the arm is bent.
  corners(withArm) {
    const { place } = this;
    const p = place.pitch_m;
    const [x, y, z] = place.pedestal_size;
    const half = place.belt_width_m / 2;
    const { d1, upper_arm: upper } = place.arm;
    const boxes = [
      [this.workspace, [0, 0, 0], place.grid.map((cells) => cells * p)],
      [matrixOf(place.pedestal), [-x / 2, -y / 2, -z], [x / 2, y / 2, 0]],
      [matrixOf(place.feeder), [p - BELT_M, -half, -p - 0.05], [p, half, 0]],
    ];
    if (withArm) {
      boxes.push([matrixOf(place.base), [-ELBOW_M, -ELBOW_M, 0], [ELBOW_M, ELBOW_M, d1 + upper]]);
    }
    return boxes.flatMap(([frame, low, high]) =>
      [0, 1, 2, 3, 4, 5, 6, 7].map((bits) =>
        new THREE.Vector3(...low.map((least, axis) => (bits & (1 << axis) ? high[axis] : least)))
          .applyMatrix4(frame),
      ),
    );
  }

  box(x, y, z, kind) {
    const mesh = new THREE.Mesh(new THREE.BoxGeometry(x, y, z), this.palette.material(kind));
    mesh.castShadow = mesh.receiveShadow = true;
    return mesh;
  }

  // The room's floor shows nothing but shade.
  ground() {
    const plane = new THREE.Mesh(
      new THREE.PlaneGeometry(8, 8),
      new THREE.ShadowMaterial({ opacity: 0.14 }),
    );
    plane.position.set(0, 0, -0.022);
    plane.receiveShadow = true;
    return plane;
  }

  floor(nx, ny, p) {
    const group = new THREE.Group();
    const plate = this.box(nx * p + 0.06, ny * p + 0.06, 0.02, "floor");
    plate.position.set((nx * p) / 2, (ny * p) / 2, -0.0115);
    const lines = [];
    for (let x = 0; x <= nx; x++) lines.push([x * p, 0, 0], [x * p, ny * p, 0]);
    for (let y = 0; y <= ny; y++) lines.push([0, y * p, 0], [nx * p, y * p, 0]);
    const points = lines.map((point) => new THREE.Vector3(...point));
    const grid = new THREE.BufferGeometry().setFromPoints(points);
    group.add(plate, new THREE.LineSegments(grid, this.palette.material("grid")));
    group.applyMatrix4(this.workspace);
    return group;
  }

  pedestal() {
    const [x, y, z] = this.place.pedestal_size;
    const block = this.box(x, y, z, "block");
    block.position.set(0, 0, -z / 2);
    const group = new THREE.Group();
    group.add(block);
    group.applyMatrix4(matrixOf(this.place.pedestal));
    return group;
  }

  belt() {
    const p = this.place.pitch_m;
    const length = BELT_M;
    const band = this.box(length, this.place.belt_width_m, 0.05, "block");
    band.position.set(-length / 2 + p, 0, -p - 0.026);
    this.onBelt = new THREE.Group();
    const group = new THREE.Group();
    group.add(band, this.onBelt);
    const drop = this.place.feeder[2] - p - 0.05;
    for (const x of [p * 0.5, p * 0.5 - length * 0.8]) {
      if (drop <= 0) break;
      const leg = this.box(0.05, this.place.belt_width_m * 0.6, drop, "block");
      leg.position.set(x - p * 0.2, 0, -p - 0.05 - drop / 2);
      group.add(leg);
    }
    group.applyMatrix4(matrixOf(this.place.feeder));
    return group;
  }

  // The parts that lie on the belt, the first at the pick station when one waits there.
  carry({ count, waiting }, geometry) {
    const key = `${count} ${waiting}`;
    if (key === this.carried) return;
    this.carried = key;
    this.onBelt.clear();
    const p = this.place.pitch_m;
    const seen = Math.min(count, 5);
    for (let i = 0; i < seen; i++) {
      const part = new Part(geometry, this.palette, "part");
      part.group.position.set(-(i + (waiting ? 0 : 1)) * p * 1.7, 0, -p / 2);
      this.onBelt.add(part.group);
    }
  }

  plate(radius) {
    const form = new THREE.CylinderGeometry(radius, radius, 0.012, 64);
    const mesh = new THREE.Mesh(form, this.palette.material("floor"));
    mesh.rotation.x = Math.PI / 2;
    mesh.position.z = -0.0075;
    mesh.receiveShadow = true;
    return mesh;
  }
}
