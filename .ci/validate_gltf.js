// Validates glTF files by the Khronos validator (npm gltf-validator), and fails if any has an error.
const fs = require("fs");
const validator = require("gltf-validator");

async function main() {
  let failed = false;
  for (const file of process.argv.slice(2)) {
    const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)));
    const { numErrors, numWarnings, messages } = report.issues;
    console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
    messages.filter((m) => m.severity === 0).slice(0, 20).forEach((m) => console.log(`  ${m.pointer}: ${m.message}`));
    failed = failed || numErrors > 0;
  }
  process.exit(failed ? 1 : 0);
}

main();
