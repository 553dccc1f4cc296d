/** An arrow of three.js, of any length and direction. */

import { ConeGeometry, CylinderGeometry, Group, Mesh, MeshBasicMaterial, Quaternion, Vector3 } from "three";

/** Radius of the shaft, radius and length of the head, in the unit that is given. */
const SHAFT = 0.024;
const HEAD = [0.07, 0.18];

const UP = new Vector3(0, 1, 0);

export class Arrow extends Group {
  /**
   * @param {number} unit  a length of the scene; the arrow is as thick as suits it
   * @param {string} colour
   */
  constructor(unit, colour) {
    super();
    this.unit = unit;
    // a force is seen through the disk, which it often points into
    const material = new MeshBasicMaterial({ color: colour, depthTest: false, transparent: true });
    this.shaft = new Mesh(new CylinderGeometry(SHAFT * unit, SHAFT * unit, 1, 16), material);
    this.head = new Mesh(new ConeGeometry(HEAD[0] * unit, HEAD[1] * unit, 24), material);
    this.shaft.renderOrder = this.head.renderOrder = 3;
    this.add(this.shaft, this.head);
  }

  /**
   * @param {Vector3} from
   * @param {Vector3} along  its length is that of the arrow
   */
  point(from, along) {
    const length = along.length();
    this.visible = length > 1e-6 * this.unit;
    if (!this.visible) return;
    this.position.copy(from);
    this.quaternion.copy(new Quaternion().setFromUnitVectors(UP, along.clone().normalize()));
    // a short arrow is all head
    const scale = Math.min(length / (HEAD[1] * this.unit), 1);
    const shaft = Math.max(length - HEAD[1] * this.unit, 0);
    this.shaft.visible = shaft > 0;
    this.shaft.scale.y = Math.max(shaft, 1e-9);
    this.shaft.position.y = shaft / 2;
    this.head.scale.setScalar(scale);
    this.head.position.y = shaft + 0.5 * scale * HEAD[1] * this.unit;
  }
}
