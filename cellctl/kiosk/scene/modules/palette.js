// The scene's colours: those of the style sheet, read anew when the theme changes.
import { THREE } from "nicegui-scene";

const NAMES = {
  part: "--part",
  added: "--part-added",
  edge: "--part-edge",
  planned: "--part-planned",
  shape: "--shape",
  arm: "--arm",
  joint: "--arm-joint",
  floor: "--floor",
  grid: "--floor-grid",
  block: "--block",
};

export class Palette {
  constructor(element) {
    this.element = element;
    this.materials = new Map();
    this.dark = false;
  }

  read() {
    // A browser resolves light-dark() only where a colour is used.
    const probe = document.createElement("i");
    // Where all transitions are short, a colour that was just set would still be the one before.
    probe.style.setProperty("transition", "none", "important");
    this.element.append(probe);
    for (const [kind, material] of this.materials) {
      probe.style.color = `var(${NAMES[kind]})`;
      material.color.set(getComputedStyle(probe).color);
    }
    probe.style.color = "var(--ground)";
    const ground = new THREE.Color(getComputedStyle(probe).color);
    this.dark = ground.r + ground.g + ground.b < 1;
    probe.remove();
  }

  material(kind) {
    if (!this.materials.has(kind)) {
      const line = kind === "edge" || kind === "planned" || kind === "grid";
      const material = line
        ? new THREE.LineBasicMaterial()
        : new THREE.MeshStandardMaterial({ roughness: 0.72, metalness: 0.02 });
      if (kind === "part" || kind === "added" || kind === "shape") material.flatShading = true;
      if (kind === "shape") material.side = THREE.DoubleSide;
      if (kind === "part" || kind === "added") {
        material.polygonOffset = true;
        material.polygonOffsetFactor = material.polygonOffsetUnits = 1;
      }
      this.materials.set(kind, material);
      this.read();
    }
    return this.materials.get(kind);
  }
}
