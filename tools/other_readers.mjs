// What two other programs make of glTF files: Khronos' glTF Validator, and the GLTFLoader of three.js. tools/fault_survey runs it.
//
//     npm install --prefix /tmp/readers gltf-validator three
//     node tools/other_readers.mjs /tmp/readers FOLDER...
//
// The first line of its output is a JSON object with the versions of both; each further line is one for a file below a FOLDER:
// `file`, its path; `codes`, the codes of the validator by severity (`errors`, `warnings`, `notes`) or the `exception` that ended
// it; `triangles`, how many of them the scene of three.js shows; `error`, the exception that ended three.js; `messages`, what it
// wrote to the console.
// Node has no images and reads no file: URLs, so both are replaced: what begins like an image
// of a kind that browsers read is an image of one pixel.
import fs from 'fs';
import path from 'path';
import { createRequire } from 'module';
import { fileURLToPath, pathToFileURL } from 'url';

const [home, ...folders] = process.argv.slice(2);
const place = name => path.resolve(home ?? '', 'node_modules', name);
const missing = ['gltf-validator', 'three'].filter(name => !fs.existsSync(place(name)));
if (missing.length || !folders.length) {
  console.error(folders.length ? `other_readers.mjs: ${missing.join(' and ')} missing: npm install --prefix ${home} gltf-validator three`
                               : 'usage: node other_readers.mjs INSTALLED FOLDER...');
  process.exit(1);
}
const require = createRequire(import.meta.url);
const versionOf = name => JSON.parse(fs.readFileSync(path.join(place(name), 'package.json'))).version;
const validator = require(place('gltf-validator'));

// The codes of the validator.
async function validate(file) {
  const levels = ['errors', 'warnings', 'notes', 'notes'];
  const codes = { errors: [], warnings: [], notes: [] };
  const resource = async uri => new Uint8Array(fs.readFileSync(path.resolve(path.dirname(file), decodeURIComponent(uri))));
  try {
    const options = { maxIssues: 0, externalResourceFunction: resource };
    const { issues } = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), options);
    for (const { severity, code } of issues.messages) if (!codes[levels[severity]].includes(code)) codes[levels[severity]].push(code);
  } catch (error) {
    codes.exception = String(error.message ?? error).split('\n')[0];
  }
  return codes;
}

globalThis.self = globalThis;
globalThis.ProgressEvent = Event;
globalThis.Request = class { constructor(url) { this.url = url; } };
globalThis.createImageBitmap = async blob => {
  const start = Buffer.from(await blob.arrayBuffer()).subarray(0, 12).toString('latin1');
  if (!/^(\x89PNG|\xff\xd8\xff|RIFF....WEBP|....ftypavif|GIF8|BM)/s.test(start)) throw new Error('this is no image');
  return { width: 1, height: 1, close() {} };
};
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
let messages = [];
for (const level of ['log', 'warn', 'error'])
  console[level] = (...words) => messages.push(words.map(word => String(word?.message ?? word)).join(' ').split('\n')[0]);
process.on('unhandledRejection', () => {});

const threeModule = name => import(pathToFileURL(path.join(place('three'), name)));
const THREE = await threeModule('build/three.module.js');
const { GLTFLoader } = await threeModule('examples/jsm/loaders/GLTFLoader.js');
const { MeshoptDecoder } = await threeModule('examples/jsm/libs/meshopt_decoder.module.js');

// three.js decodes Draco in a web worker, which Node lacks; this calls the same decoder.
const dracoFile = path.join(place('three'), 'examples/jsm/libs/draco/gltf/draco_decoder.js');
const wrapped = { exports: {} };
new Function('module', 'exports', 'require', '__dirname', fs.readFileSync(dracoFile, 'utf8'))(
  wrapped, wrapped.exports, require, path.dirname(dracoFile));
const draco = await new Promise(done => wrapped.exports({ onModuleLoaded: module => done({ module }) }));
const dracoLoader = {
  preload() {},
  decodeDracoFile(buffer, callback, attributeIds, types, colorSpace, fail) {
    const { module } = draco, decoder = new module.Decoder(), mesh = new module.Mesh();
    if (!decoder.DecodeArrayToMesh(new Int8Array(buffer), buffer.byteLength, mesh).ok()) return fail(new Error('Draco decoding failed'));
    const geometry = new THREE.BufferGeometry(), points = mesh.num_points();
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(3 * mesh.num_faces()), 1));
    for (const name of Object.keys(attributeIds)) geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * points), 3));
    callback(geometry);
  },
};

// How many triangles a file's scene shows in three.js.
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

const print = row => process.stdout.write(JSON.stringify(row) + '\n');
print({ 'gltf-validator': versionOf('gltf-validator'), three: versionOf('three'), node: process.version });
for (const folder of folders) {
  for (const name of fs.readdirSync(folder, { recursive: true }).filter(name => /\.gl(tf|b)$/.test(name)).sort()) {
    const file = path.resolve(folder, name);
    const row = { file, codes: await validate(file), triangles: 0, error: '' };
    messages = [];
    try {
      row.triangles = await load(file);
    } catch (error) {
      row.error = String(error.message ?? error).split('\n')[0];
    }
    print({ ...row, messages });
  }
}
process.exit(0);
