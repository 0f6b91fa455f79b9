// The answer of /api/octomap: "TLVX", uint32 count, float32 resolution_m, then
// count times 3 float32, the centres of occupied voxels. Little-endian.

const MAGIC = 0x58564c54;  // "TLVX", little-endian
const HEADER_BYTES = 12;

export interface Octomap {
  resolution: number;
  // x, y, z of each voxel (m, map).
  centres: Float32Array;
}

export function decodeOctomap(bytes: ArrayBuffer): Octomap {
  const view = new DataView(bytes);
  if (bytes.byteLength < HEADER_BYTES || view.getUint32(0, true) !== MAGIC) {
    throw new Error('the OctoMap does not begin with TLVX');
  }
  const count = view.getUint32(4, true);
  const resolution = view.getFloat32(8, true);
  if (bytes.byteLength !== HEADER_BYTES + 12 * count) {
    throw new Error(
        `the OctoMap has ${bytes.byteLength} bytes, which is not what ` +
        `${count} voxels take`);
  }
  if (!(resolution > 0)) {
    throw new Error('the OctoMap\'s resolution is not above 0');
  }
  const centres = new Float32Array(3 * count);
  for (let i = 0; i < centres.length; ++i) {
    centres[i] = view.getFloat32(HEADER_BYTES + 4 * i, true);
  }
  return { resolution, centres };
}
