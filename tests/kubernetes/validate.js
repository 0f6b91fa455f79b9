// Run in the folder that has node_modules: checks Kubernetes objects against the schemas that Kubernetes publishes, as
// npm's kubernetes-models has them compiled. Standard input: a JSON array of
// objects. Standard output: a JSON array, the objections to each.

const fs = require('fs');
const path = require('path');

// By their path: the package names the classes made of them alone.
const SCHEMAS = path.join('node_modules', 'kubernetes-models', '_schemas');
const CORE = 'core';

// Views of objects that note which of their fields are looked at. The schemas
// let fields pass that they do not know; but a validator reads each field that
// it knows by its name, and nothing of the others.
function watched(value, where, unseen) {
  if (value === null || typeof value !== 'object') return value;
  if (!Array.isArray(value)) {
    unseen.set(value, { where, keys: new Set(Object.keys(value)) });
  }
  const views = new Map(Object.keys(value).map((key) =>
    [key, watched(value[key], `${where}/${key}`, unseen)]));
  return new Proxy(value, {
    get(target, key) {
      unseen.get(target)?.keys.delete(key);
      return views.has(key) ? views.get(key) : target[key];
    },
  });
}

function objectionsTo(object) {
  const schema = path.resolve(SCHEMAS, `${schemaOf(object)}.js`);
  if (!fs.existsSync(schema)) {
    return [`there is no ${object.kind} of ${object.apiVersion}`];
  }
  const unseen = new Map();
  const { validate } = require(schema);
  const objections = validate(watched(object, '', unseen)) ? [] :
    validate.errors.map((error) =>
      `${error.instancePath}: ${error.keyword} ${JSON.stringify(error.params)}`);
  for (const { where, keys } of unseen.values()) {
    for (const key of keys) objections.push(`${where}/${key}: no such field`);
  }
  return objections;
}

// "apps/v1" and "Deployment": IoK8sApiAppsV1Deployment.
function schemaOf({ apiVersion = '', kind = '' }) {
  const [group, version] = apiVersion.includes('/') ? apiVersion.split('/') :
    [CORE, apiVersion];
  const capital = (word) => word.charAt(0).toUpperCase() + word.slice(1);
  return `IoK8sApi${capital(group.split('.')[0])}${capital(version)}${kind}`;
}

const objects = JSON.parse(fs.readFileSync(0, 'utf8'));
process.stdout.write(JSON.stringify(objects.map(objectionsTo)) + '\n');
