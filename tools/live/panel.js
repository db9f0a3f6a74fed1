// The sliders: one for each key that can be turned, on a logarithmic scale, with what is typed in any of its units.
'use strict';

const keyNames = {
  'limit.energy': 'limit', 'limit.density': 'limit', 'limit.stretch': 'limit', 'material.young': 'stiffness', 'material.density': 'density',
  'material.damping_mass': 'damping of motion', 'material.damping_stiffness': 'damping of deformation', 'friction': 'friction', 'clip.gravity': 'gravity'};

const presetsOf = {
  '%': [[2, '2 %'], [5, '5 %'], [10, '10 %'], [20, '20 %'], [40, '40 %']],
  'kPa': [[10, 'jelly: 10 kPa'], [100, 'soft foam: 100 kPa'], [500, '500 kPa'], [2000, 'rubber: 2 MPa'], [20000, 'hard rubber: 20 MPa']],
  'kg/m³': [[30, 'foam: 30'], [500, '500'], [1000, 'water: 1000'], [2500, 'stone: 2500']],
  'm/s²': [[0, 'none: 0'], [1.62, 'Moon: 1.62'], [3.71, 'Mars: 3.71'], [9.81, 'Earth: 9.81'], [24.8, 'Jupiter: 24.8']],
  '1/s': [[0, 'none: 0'], [0.5, '0.5'], [2, '2'], [10, '10']],
  's': [[0, 'none: 0'], [0.001, '0.001'], [0.01, '0.01'], [0.05, '0.05']],
  '': [[0, 'none: 0'], [0.1, 'ice: 0.1'], [0.5, 'wood: 0.5'], [1, 'rubber: 1']]};

// what units stand for, in the key's own
const unitScales = {'%': {'%': 1}, 'kPa': {Pa: 1e-3, kPa: 1, MPa: 1e3, GPa: 1e6}, 'J': {J: 1, mJ: 1e-3, kJ: 1e3}, 'J/m³': {'J/m^3': 1, 'J/m³': 1, 'kJ/m^3': 1e3, 'kJ/m³': 1e3},
  'kg/m³': {'kg/m^3': 1, 'kg/m³': 1, 'g/cm^3': 1e3, 'g/cm³': 1e3}, 'm/s²': {'m/s^2': 1, 'm/s²': 1, g: 9.81}, '1/s': {'1/s': 1}, 's': {s: 1, ms: 1e-3}, '': {}};

// The number that a text means, in the key's shown unit; NaN: none.
function typedNumber(text, unit) {
  const parts = text.trim().match(/^([-+]?[0-9]*\.?[0-9]+(?:e[-+]?[0-9]+)?)\s*(.*)$/i);
  if (!parts) return NaN;
  if (!parts[2]) return Number(parts[1]);
  const scale = (unitScales[unit] || {})[parts[2]];
  return scale === undefined ? NaN : Number(parts[1]) * scale;
}

function shownNumber(value) {
  if (value === 0) return '0';
  return Math.abs(value) >= 1e5 || Math.abs(value) < 1e-3 ? value.toExponential(2).replace('e+', 'e') : String(Number(value.toPrecision(4)));
}

class Slider {
  // about: the key as the server tells it; turned(value): called with what is wished, in the scene's unit
  constructor(about, body, turned) {
    this.about = about, this.turned = turned, this.touched = -1e9;
    const short = about.path.replace(/^body\.[^.]*\./, '').replace(/^body\..*?\.(limit|material|friction)/, '$1');
    const part = short.match(/^limit\.(volumetric|deviatoric|fibre)\./);
    this.name = part ? 'limit, ' + part[1] : keyNames[short] || keyNames[about.path] || short;
    this.element = document.createElement('div');
    this.element.className = 'key' + (about.animated ? ' fixed' : '');
    this.element.innerHTML = '<div class="line"><label></label><input type="text" spellcheck="false"><span class="unit"></span></div>' +
      '<div class="of"><div class="rail"><input type="range" min="0" max="1000" step="1"><div class="ghost" hidden></div></div><select aria-label="presets"><option value=""></option></select></div>' +
      '<div class="now" hidden></div>';
    const find = selector => this.element.querySelector(selector);
    this.text = find('input[type=text]'), this.range = find('input[type=range]'), this.ghost = find('.ghost'), this.now = find('.now'), this.presets = find('select');
    find('label').textContent = this.name, find('label').title = about.path + (about.animated ? ': keyframes of the scene' : '');
    this.text.setAttribute('aria-label', about.path), this.range.setAttribute('aria-label', this.name), this.range.dataset.key = about.path;
    find('.unit').textContent = about.unit;
    this.fillPresets();
    this.range.addEventListener('input', () => this.wish(this.fromShare(this.range.value / 1000)));
    this.text.addEventListener('change', () => this.typed());
    this.presets.addEventListener('change', () => { if (this.presets.value !== '') this.wish(Number(this.presets.value) / about.scale); this.presets.value = ''; });
    if (about.animated) this.enable(false);
  }

  fillPresets() {
    const none = this.about.none ? [[this.about.none * this.about.scale, 'none']] : [];
    for (const [value, words] of [...(presetsOf[this.about.unit] || []), ...none]) {
      const option = document.createElement('option');
      option.value = value, option.textContent = words;
      this.presets.append(option);
    }
    this.presets.hidden = this.presets.options.length < 2;
  }

  enable(yes) {
    this.text.disabled = this.range.disabled = this.presets.disabled = !yes || this.about.animated;
  }

  // a value in words: a limit that is none has no number
  shown(value) {
    return this.about.none && value >= this.about.none ? 'none' : shownNumber(value * this.about.scale);
  }

  typed() {
    const none = this.about.none && this.text.value.trim() === 'none';
    const value = none ? this.about.none : typedNumber(this.text.value, this.about.unit) / this.about.scale;
    if (value >= this.about.least && value <= this.about.most) this.wish(value);
    else this.show(this.value, this.goal, true);
  }

  wish(value) {
    this.touched = performance.now();
    this.goal = value;
    this.text.value = this.shown(value);
    this.range.value = 1000 * this.toShare(value);
    this.turned(value);
  }

  // the lowest twentieth is 0 where the key may be 0, the highest is none where it may be none
  toShare(value) {
    const {low, high, least, none} = this.about, from = least === 0 ? 0.05 : 0, to = none ? 0.95 : 1;
    if (value <= 0) return 0;
    if (none && value >= none) return 1;
    const share = Math.log(value / low) / Math.log(high / low);
    return from + (to - from) * Math.min(1, Math.max(0, share));
  }
  fromShare(share) {
    const {low, high, least, none} = this.about, from = least === 0 ? 0.05 : 0, to = none ? 0.95 : 1;
    if (least === 0 && share < 0.025) return 0;
    if (none && share > 0.975) return none;
    const value = low * Math.pow(high / low, Math.min(1, Math.max(0, (share - from) / (to - from))));
    return Number(value.toPrecision(3));
  }

  // value: what acts; goal: where it is heading
  show(value, goal, always) {
    this.value = value;
    const falls = Math.abs(value - goal) > 1e-9 * Math.abs(goal);
    this.ghost.hidden = this.now.hidden = !falls;
    if (falls) {
      this.ghost.style.left = (7 + this.toShare(value) * (this.range.clientWidth - 14)) + 'px';
      this.now.textContent = 'now ' + shownNumber(value * this.about.scale) + ' ' + this.about.unit + ', falling at 50 % stretch a second';
    }
    if (!always && (document.activeElement === this.text || performance.now() - this.touched < 400)) return;
    this.goal = goal;
    this.text.value = this.shown(goal);
    this.range.value = 1000 * this.toShare(goal);
  }
}

// The number of a body's hexes, whose change starts everything again. caged(cells): called with what is wished.
class CellsField {
  constructor(body, most, caged) {
    this.element = document.createElement('div');
    this.element.className = 'key';
    this.element.innerHTML = '<div class="line"><label></label><input type="text" inputmode="numeric" spellcheck="false"><span class="unit">hexes</span></div>';
    const label = this.element.querySelector('label');
    this.text = this.element.querySelector('input');
    label.textContent = 'cage', label.title = 'body.' + body.name + '.cage.cells: another cage starts everything again';
    this.text.setAttribute('aria-label', 'body.' + body.name + '.cage.cells');
    this.text.value = body.hexes;
    this.text.addEventListener('change', () => {
      const wanted = Number(this.text.value);
      if (Number.isInteger(wanted) && wanted >= 1 && wanted <= most) caged(wanted);
      else this.text.value = body.hexes, toast('a cage has 1 to ' + most + ' hexes', true);
    });
  }

  enable(yes) {
    this.text.disabled = !yes;
  }
}

// Fills the panel; turned(key, value), caged(body, cells). Returns the sliders in the order of the keys, and the fields of cages.
function makeSliders(hello, panel, turned, caged) {
  panel.textContent = '';
  const sections = new Map();
  const section = body => {
    if (!sections.has(body)) {
      const element = document.createElement('section'), title = document.createElement('h2');
      title.textContent = body < 0 ? 'world' : hello.bodies[body].name;
      element.append(title);
      panel.append(element);
      sections.set(body, element);
    }
    return sections.get(body);
  };
  const sliders = hello.keys.map((about, i) => {
    const slider = new Slider(about, about.body, value => turned(i, value));
    section(about.body).append(slider.element);
    slider.show(hello.values[i], hello.goals[i], true);
    return slider;
  });
  const fields = [];
  hello.bodies.forEach((body, b) => {
    if (!body.cells) return;
    fields.push(new CellsField(body, hello.most_cells, cells => caged(b, cells)));
    section(b).append(fields[fields.length - 1].element);
  });
  return {sliders, fields};
}
