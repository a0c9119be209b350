// The cell in three dimensions, or an object on a turntable. Draws only when something has changed
// or turns, stands still for those who asked their system for less motion, and leaves a slow computer
// to what listens and moves.
import { GLTFLoader, THREE } from "nicegui-scene";
import { Arm } from "cellctl-scene/arm.js";
import { Furniture, ghost, Part, partGeometry } from "cellctl-scene/parts.js";
import { Palette } from "cellctl-scene/palette.js";

const TURN_S = 26; // one turn of the turntable
const SWAY_S = 40; // the camera's way to and fro before the cell
const SWAY_RAD = 0.32;
const TURN_A_PIXEL_RAD = 0.008;
const FRAME_S = 1 / 30;
const SCREEN_S = 1 / 50; // from one frame of the screen to the next, where drawing takes no time
const SHARE = 1 / 4; // of all time, that may be spent on drawing
const CAPTIONS_PX = 60; // how high the captions below the plates are
const FILLED = 0.9; // of the picture's width or height, by what is seen
const PLATE = 0.53; // radius of a plate, by the diagonal of what turns on it
const ARRIVE_S = 0.45; // how long a part takes to appear

export default {
  template: `<div class="stage__canvas" role="img" :aria-label="label"></div>`,
  props: { geometry: Object, label: String },

  mounted() {
    this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
    try {
      this.renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
    } catch {
      this.$el.dataset.failed = "true"; // the style sheet says that there is no 3D here
      return;
    }
    this.setUp();
    this.watcher = new ResizeObserver(() => this.resize());
    this.watcher.observe(this.$el);
    this.themes = new MutationObserver(() => this.recolour());
    this.themes.observe(document.documentElement, { attributes: true, attributeFilter: ["data-theme"] });
    this.scheme = window.matchMedia("(prefers-color-scheme: dark)");
    this.recoloured = () => this.recolour();
    this.scheme.addEventListener("change", this.recoloured);
    this.resize();
    this.before = 0;
    this.drew = false;
    this.cost_s = 0;
    this.loop = (now) => {
      this.frame = requestAnimationFrame(this.loop);
      const passed = (now - this.before) / 1000;
      if (this.drew) {
        // How late the screen's next frame is tells how long this one took to draw.
        this.drew = false;
        this.cost_s += 0.3 * (Math.min(1, Math.max(0, passed - SCREEN_S)) - this.cost_s);
      }
      if (passed < Math.max(FRAME_S * 0.9, this.cost_s / SHARE)) return;
      this.before = now;
      if (!document.hidden) this.drew = this.advance(Math.min(1, passed));
    };
    this.frame = requestAnimationFrame(this.loop);
    this.$emit("ready");
  },

  unmounted() {
    cancelAnimationFrame(this.frame);
    this.watcher?.disconnect();
    this.themes?.disconnect();
    this.scheme?.removeEventListener("change", this.recoloured);
    this.renderer?.dispose();
  },

  methods: {
    setUp() {
      const place = this.geometry;
      this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
      this.renderer.shadowMap.enabled = true;
      this.renderer.shadowMap.type = THREE.PCFSoftShadowMap;
      this.$el.append(this.renderer.domElement);
      // Turned by hand, for those who want to see the other side, or whose picture stands still.
      this.turned = 0;
      this.$el.addEventListener("pointermove", (event) => {
        if (!event.buttons) return;
        this.turned += event.movementX * TURN_A_PIXEL_RAD;
        this.dirty = true;
      });
      this.palette = new Palette(this.$el);
      this.scene = new THREE.Scene();
      this.camera = new THREE.PerspectiveCamera(30, 1, 0.05, 40);
      this.camera.up.set(0, 0, 1);
      this.lights();
      this.part = partGeometry(place.pitch_m);

      this.cell = new THREE.Group(); // the workspace, the arm, the belt
      this.furniture = new Furniture(place, this.palette);
      this.corners = {
        withArm: this.furniture.corners(true),
        without: this.furniture.corners(false),
      };
      this.arm = new Arm(place, this.palette);
      this.parts = new THREE.Group();
      this.cell.add(this.furniture.group, this.arm.group, this.parts);
      this.held = new Part(this.part, this.palette, "part");
      this.arm.tip.add(this.held.group);
      this.held.group.visible = false;

      this.table = new THREE.Group(); // what turns: the voxels, and the shape beside them
      this.voxels = new THREE.Group();
      this.shape = new THREE.Group();
      this.table.add(this.voxels, this.shape);
      this.scene.add(this.cell, this.table);
      this.standing = new Map();
      this.mode = "cell";
      this.angle = 0;
      this.time = 0;
      this.dirty = true;
      this.recolour();
    },

    lights() {
      this.sky = new THREE.HemisphereLight(0xffffff, 0xb9b2a4, 1.7);
      this.sun = new THREE.DirectionalLight(0xffffff, 2.2);
      this.sun.position.set(1.6, 2.0, 3.2);
      this.sun.castShadow = true;
      this.sun.shadow.mapSize.set(1024, 1024);
      this.sun.shadow.radius = 5;
      const seen = this.sun.shadow.camera;
      Object.assign(seen, { left: -1.6, right: 1.6, top: 1.6, bottom: -1.6, near: 0.5, far: 9 });
      this.scene.add(this.sky, this.sun, this.sun.target);
    },

    resize() {
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      this.renderer.setSize(width, height);
      this.camera.aspect = width / height;
      this.camera.updateProjectionMatrix();
      this.dirty = true;
    },

    recolour() {
      this.palette.read();
      this.sky.intensity = this.palette.dark ? 1.15 : 1.7;
      this.sky.groundColor.set(this.palette.dark ? 0x39424b : 0xb9b2a4);
      this.dirty = true;
    },

    // What stands, what is planned, and where it was changed; see `pictures.py`.
    show(picture) {
      if (!this.renderer) return;
      this.mode = picture.mode;
      this.cell.visible = picture.mode === "cell";
      this.table.visible = picture.mode === "table";
      if (picture.mode === "cell") this.showCell(picture);
      else this.showTable(picture);
      this.dirty = true;
    },

    showCell(picture) {
      const wanted = new Map(picture.standing.map((cell) => [cell.join(), cell]));
      for (const [key, part] of this.standing) {
        if (wanted.has(key)) continue;
        this.parts.remove(part.group);
        this.standing.delete(key);
      }
      for (const [key, cell] of wanted) {
        if (this.standing.has(key)) continue;
        const part = new Part(this.part, this.palette, "part");
        part.group.position.copy(this.centre(cell));
        part.age = this.known && !this.still.matches ? 0 : ARRIVE_S;
        this.standing.set(key, part);
        this.parts.add(part.group);
      }
      this.known = true;
      if (this.ghosts) this.cell.remove(this.ghosts);
      this.ghosts = ghost(picture.planned.map((c) => this.centre(c)), this.part, this.palette);
      this.cell.add(this.ghosts);
      this.furniture.carry(picture.belt, this.part);
      this.held.group.visible = picture.held;
    },

    centre(cell) {
      const pitch = this.geometry.pitch_m;
      const at = new THREE.Vector3(...cell).addScalar(0.5).multiplyScalar(pitch);
      return at.applyMatrix4(this.furniture.workspace);
    },

    showTable(picture) {
      const pitch = this.geometry.pitch_m;
      this.voxels.clear();
      const all = [...picture.kept, ...picture.added, ...picture.left_out];
      const low = new THREE.Vector3(Infinity, Infinity, Infinity);
      const high = low.clone().negate();
      for (const cell of all) {
        low.min(new THREE.Vector3(...cell));
        high.max(new THREE.Vector3(...cell).addScalar(1));
      }
      const middle = low.clone().add(high).multiplyScalar(0.5).setZ(low.z);
      this.size = high.clone().sub(low).multiplyScalar(pitch);
      const at = (cell) =>
        new THREE.Vector3(...cell).addScalar(0.5).sub(middle).multiplyScalar(pitch);
      for (const [kind, cells] of [["part", picture.kept], ["added", picture.added]]) {
        for (const cell of cells) {
          const part = new Part(this.part, this.palette, kind);
          part.group.position.copy(at(cell));
          this.voxels.add(part.group);
        }
      }
      this.voxels.add(ghost(picture.left_out.map(at), this.part, this.palette));
      this.voxels.add(this.furniture.plate(PLATE * Math.hypot(this.size.x, this.size.y) + pitch / 4));
      this.showShape(picture.mesh);
    },

    async showShape(url) {
      if (url === this.shapeUrl) return this.placeShape();
      this.shapeUrl = url;
      this.shape.clear();
      this.placeShape();
      if (!url) return;
      let found;
      try {
        found = await new GLTFLoader().loadAsync(url);
      } catch {
        return; // there is no shape to show, which the words beside it do not promise either
      }
      if (url !== this.shapeUrl) return;
      const model = found.scene;
      model.rotation.x = Math.PI / 2; // glTF has y up
      model.updateMatrixWorld(true);
      const box = new THREE.Box3().setFromObject(model);
      const extent = box.getSize(new THREE.Vector3());
      const tallest = Math.max(this.size.x, this.size.y, this.size.z);
      const scale = tallest / Math.max(extent.x, extent.y, extent.z, 1e-6);
      const centre = box.getCenter(new THREE.Vector3());
      model.position.set(-centre.x, -centre.y, -box.min.z);
      const turned = new THREE.Group();
      turned.scale.setScalar(scale);
      turned.add(model);
      model.traverse((node) => {
        if (!node.isMesh) return;
        node.material = this.palette.material("shape");
        node.castShadow = true;
      });
      const plate = this.furniture.plate(
        PLATE * scale * Math.hypot(extent.x, extent.y) + this.geometry.pitch_m / 4,
      );
      this.shape.add(turned, plate);
      this.placeShape();
      this.dirty = true;
    },

    placeShape() {
      const beside = this.shape.children.length > 0;
      const apart = PLATE * Math.hypot(this.size.x, this.size.y) + this.geometry.pitch_m * 0.4;
      this.apart = apart;
      this.pair = beside;
      this.place();
    },

    // The shape to the left of the voxels.
    place() {
      const apart = this.pair ? this.apart : 0;
      // The camera looks along -y, so that +x is to the left.
      this.shape.position.set(apart, 0, 0);
      this.voxels.position.set(-apart, 0, 0);
      this.dirty = true;
    },

    pose(joints) {
      if (this.renderer && this.arm.wants(joints, this.still.matches)) this.dirty = true;
    },

    advance(passed) {
      this.time += passed;
      let moving = this.arm.advance(passed);
      for (const part of this.standing.values()) {
        if (part.age >= ARRIVE_S) continue;
        part.age += passed;
        part.group.scale.setScalar(Math.min(1, 0.4 + (0.6 * part.age) / ARRIVE_S));
        moving = true;
      }
      const turns = !this.still.matches;
      if (turns && this.mode === "table") this.angle += (passed * 2 * Math.PI) / TURN_S;
      if (!(moving || turns || this.dirty)) return false;
      this.dirty = false;
      this.voxels.rotation.z = this.shape.rotation.z = 0.6 + this.angle + this.turned;
      this.look();
      this.renderer.render(this.scene, this.camera);
      return true;
    },

    // Moves the picture up by that share of its height.
    shiftUp(share) {
      const { clientWidth: width, clientHeight: height } = this.$el;
      if (!width || !height) return;
      if (share) this.camera.setViewOffset(width, height, 0, share * height, width, height);
      else this.camera.clearViewOffset();
    },

    // Tells the style sheet where the plates are, so that the captions are right below them.
    placeCaptions() {
      this.camera.updateMatrixWorld();
      const radius = this.apart - this.geometry.pitch_m * 0.15;
      const seen = (x, y) => new THREE.Vector3(x, y, 0).project(this.camera);
      const across = (x) => `${(50 + 50 * seen(x, 0).x).toFixed(1)}%`;
      const apart = this.pair ? this.apart : 0;
      const style = this.$el.closest("figure")?.style;
      style?.setProperty("--shape-x", across(apart));
      style?.setProperty("--voxels-x", across(-apart));
      const low = seen(apart, radius).y;
      style?.setProperty("--captions-y", `${(50 - 50 * low + 2).toFixed(1)}%`);
    },

    look() {
      if (this.mode === "table") {
        const width = this.pair ? 4 * this.apart : 2.4 * this.apart;
        const height = this.size.z + 0.35 * width;
        const fit = Math.max(height, width / this.camera.aspect);
        // Below the plates there is room for their captions.
        const room = Math.min(0.4, CAPTIONS_PX / this.$el.clientHeight);
        const away = ((0.56 / (1 - room)) * fit) / Math.tan((this.camera.fov * Math.PI) / 360);
        const target = new THREE.Vector3(0, 0, this.size.z * 0.46);
        this.camera.position.set(0, away * 0.9, target.z + away * 0.38);
        this.camera.lookAt(target);
        this.shiftUp(room / 2);
        this.sun.target.position.copy(target);
        this.placeCaptions();
        return;
      }
      this.shiftUp(0);
      const sway = this.still.matches ? 0.25 : Math.sin((this.time * 2 * Math.PI) / SWAY_S);
      const around = 0.62 + SWAY_RAD * sway - this.turned;
      const towards = new THREE.Vector3(Math.sin(around), Math.cos(around), 0.4).normalize();
      this.frameAll(this.arm.group.visible ? this.corners.withArm : this.corners.without, towards);
      this.sun.target.position.copy(this.furniture.middle);
    },

    // Looks along that way from where all these points are just seen, in the middle of the picture.
    frameAll(points, towards) {
      const { camera } = this;
      camera.position.copy(towards);
      camera.lookAt(0, 0, 0);
      const right = new THREE.Vector3(1, 0, 0).applyQuaternion(camera.quaternion);
      const up = new THREE.Vector3(0, 1, 0).applyQuaternion(camera.quaternion);
      const steep = FILLED * Math.tan((camera.fov * Math.PI) / 360);
      // How far out of the middle the camera has to be, and how far back, by either direction.
      const [x, y] = [[right, steep * camera.aspect], [up, steep]].map(([across, slope]) => {
        const ends = points.map((p) => [p.dot(across), slope * p.dot(towards)]);
        const most = Math.max(...ends.map(([at, nearer]) => at + nearer));
        const least = Math.min(...ends.map(([at, nearer]) => at - nearer));
        return { at: (most + least) / 2, back: (most - least) / 2 / slope };
      });
      camera.position
        .copy(towards)
        .multiplyScalar(Math.max(x.back, y.back))
        .addScaledVector(right, x.at)
        .addScaledVector(up, y.at);
    },
  },
};
