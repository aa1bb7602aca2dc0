// Loads the glTF files of a corpus with three.js' GLTFLoader, and prints one line of JSON for each:
// the file, how many triangles its scene shows, and the exception that ended it, if one did.
//
//     npm install --prefix /tmp/three three
//     cp tools/three_reach.mjs /tmp/three && node /tmp/three/three_reach.mjs ../shared/corpus > reach.jsonl
//
// Node has no images and reads no file: URLs, so both are replaced: any image is one pixel.
import fs from 'fs';
import path from 'path';
import { createRequire } from 'module';
import { fileURLToPath } from 'url';

globalThis.self = globalThis;
globalThis.ProgressEvent = Event;
globalThis.Request = class { constructor(url) { this.url = url; } };
globalThis.createImageBitmap = async () => ({ width: 1, height: 1, close() {} });
const fetchUrl = globalThis.fetch;
globalThis.fetch = async request => {
  const url = request.url ?? request;
  if (/^(data|blob):/.test(url)) return fetchUrl(url);
  if (/^https?:/.test(url)) throw new Error('there is no network');
  try {
    return new Response(fs.readFileSync(url.startsWith('file:') ? fileURLToPath(url) : decodeURIComponent(url)));
  } catch {
    return new Response(null, { status: 404 });
  }
};
for (const level of ['log', 'warn', 'error']) console[level] = () => {};
process.on('unhandledRejection', () => {});

const THREE = await import('three');
const { GLTFLoader } = await import('three/examples/jsm/loaders/GLTFLoader.js');
const { MeshoptDecoder } = await import('three/examples/jsm/libs/meshopt_decoder.module.js');

// three.js decodes Draco in a web worker, which Node lacks; this calls the same decoder.
const require = createRequire(import.meta.url);
const dracoFile = require.resolve('three/examples/jsm/libs/draco/gltf/draco_decoder.js');
const wrapped = { exports: {} };
new Function('module', 'exports', 'require', '__dirname', fs.readFileSync(dracoFile, 'utf8'))(
  wrapped, wrapped.exports, require, path.dirname(dracoFile));
const draco = await new Promise(done => wrapped.exports({ onModuleLoaded: module => done({ module }) }));
const dracoLoader = {
  preload() {},
  decodeDracoFile(buffer, callback, attributeIds) {
    const { module } = draco, decoder = new module.Decoder(), mesh = new module.Mesh();
    if (!decoder.DecodeArrayToMesh(new Int8Array(buffer), buffer.byteLength, mesh).ok()) throw new Error('Draco');
    const geometry = new THREE.BufferGeometry(), points = mesh.num_points();
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(3 * mesh.num_faces()), 1));
    for (const name of Object.keys(attributeIds)) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * points), 3));
    callback(geometry);
  },
};

async function load(file) {
  const bytes = fs.readFileSync(file);
  const loader = new GLTFLoader().setMeshoptDecoder(MeshoptDecoder).setDRACOLoader(dracoLoader);
  loader.setKTX2Loader({ load: (url, done) => done(new THREE.Texture()) });
  const late = new Promise((_, fail) => setTimeout(() => fail(new Error('takes more than 20 s')), 20000).unref());
  const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
  const { scene } = await Promise.race([loader.parseAsync(buffer, path.dirname(file) + '/'), late]);
  let triangles = 0;
  scene?.traverse(({ isMesh, geometry }) => {
    if (isMesh && geometry.attributes.position) triangles += Math.floor((geometry.index ?? geometry.attributes.position).count / 3);
  });
  return triangles;
}

const corpus = path.resolve(process.argv[2]);
for (const folder of ['valid', 'invalid', 'reported']) {
  const names = fs.readdirSync(path.join(corpus, folder), { recursive: true }).filter(name => /\.gl(tf|b)$/.test(name)).sort();
  for (const name of names) {
    const row = { file: path.join(folder, name), triangles: 0, error: '' };
    try {
      row.triangles = await load(path.join(corpus, row.file));
    } catch (error) {
      row.error = String(error.message ?? error).split('\n')[0];
    }
    process.stdout.write(JSON.stringify(row) + '\n');
  }
}
process.exit(0);
