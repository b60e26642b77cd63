'use strict';
// Findings of the engine and the studio's server (FfpFinding as JSON): an item of a list each, its remedy below.

function findingItem(finding) {
  const item = document.createElement('li'), subject = finding.subject[0].toUpperCase() + finding.subject.slice(1);
  item.className = finding.severity;
  item.dataset.code = finding.code;
  item.textContent = `${subject}${finding.view ? `, view ${finding.view}` : ''}: ${finding.text}`;
  if (finding.advice) {
    const remedy = document.createElement('small');
    remedy.className = 'remedy';
    remedy.textContent = finding.advice;
    item.append(remedy);
  }
  return item;
}

// The nodes that tell of an error by a finding: its own words, which name the file or view, and the remedy below, not twice.
function faultSaid(message, finding) {
  return [finding.advice ? message.replace(`: ${finding.advice}`, '') : message, ...findingItem(finding).children];
}

const isPassed = (finding) => finding.severity === 'ok';
const isDoubt = ({severity}) => severity === 'doubt' || severity === 'fault'; // a note asks for nothing
