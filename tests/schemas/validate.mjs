// Validates scenes against schemas, with ajv: validate.mjs < LIST > RESULTS
// LIST: a JSON array of [schema file, scene file]. RESULTS: for each, whether the scene is JSON
// (// comments and a byte order mark apart), whether the schema accepts it, and where it does not.
import { readFileSync } from "node:fs";
import Ajv2020 from "ajv/dist/2020.js";

const strings_or_comments = /"(?:\\.|[^"\\])*"|\/\/[^\r\n]*/g;

function parse(bytes) {
  const text = new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  return JSON.parse(text.replace(strings_or_comments, (part) => (part[0] === '"' ? part : " ")));
}

function judge(validate, file) {
  let scene;
  try {
    scene = parse(readFileSync(file));
  } catch {
    return { json: false };
  }
  const accepted = validate(scene);
  const errors = (validate.errors ?? []).slice(0, 20);
  return { json: true, accepted, errors: errors.map((e) => [e.instancePath, e.message]) };
}

// What only editors read; all else that ajv does not know is a mistake.
const ajv = new Ajv2020({ strict: true, allErrors: true });
ajv.addVocabulary(["allowComments", "enumDescriptions"]);

const validators = new Map();
function validator_of(schema) {
  if (!validators.has(schema)) {
    validators.set(schema, ajv.compile(JSON.parse(readFileSync(schema, "utf8"))));
  }
  return validators.get(schema);
}

const list = JSON.parse(readFileSync(0, "utf8"));
const results = list.map(([schema, file]) => judge(validator_of(schema), file));
process.stdout.write(JSON.stringify(results));
