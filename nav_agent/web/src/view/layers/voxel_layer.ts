// The OctoMap, coloured by height and cut open above the robot.

import {
  BufferAttribute, BufferGeometry, Group, Mesh, MeshBasicMaterial,
} from 'three';

import { drawnBelow, type Faces, type VoxelMesh } from '../../model/voxel_mesh.js';

function geometryOf(faces: Faces): BufferGeometry {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(faces.positions, 3));
  geometry.setAttribute('color', new BufferAttribute(faces.colours, 3, true));
  const indices = new Uint32Array(6 * faces.rectangles);
  for (let i = 0; i < faces.rectangles; ++i) {
    indices.set([0, 1, 2, 0, 2, 3].map((corner) => 4 * i + corner), 6 * i);
  }
  geometry.setIndex(new BufferAttribute(indices, 1));
  return geometry;
}

export class VoxelLayer {
  readonly object = new Group();
  private readonly material = new MeshBasicMaterial({ vertexColors: true });
  private mesh: VoxelMesh | null = null;
  private body: Mesh | null = null;
  private caps: Mesh | null = null;
  private height = Infinity;

  set(mesh: VoxelMesh | null): void {
    for (const part of [this.body, this.caps]) {
      if (part === null) continue;
      this.object.remove(part);
      part.geometry.dispose();
    }
    this.mesh = mesh;
    this.body = this.caps = null;
    if (mesh === null) return;
    this.body = new Mesh(geometryOf(mesh.body), this.material);
    this.caps = new Mesh(geometryOf(mesh.caps), this.material);
    this.object.add(this.body, this.caps);
    this.cutAt(this.height);
  }

  // Whether that changed what is drawn.
  cutAt(height: number): boolean {
    this.height = height;
    if (this.mesh === null || !this.body || !this.caps) return false;
    const drawn = drawnBelow(this.mesh, height);
    const [begin, end] = drawn.caps;
    const before = this.body.geometry.drawRange.count;
    this.body.geometry.setDrawRange(0, 6 * drawn.body);
    this.caps.geometry.setDrawRange(6 * begin, 6 * (end - begin));
    return before !== 6 * drawn.body;
  }
}
