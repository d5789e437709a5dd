// Contents list from the headings, then every figure from its specification. `data-shown` tells a test how each ended.
const contents = document.querySelector('nav');
for (const section of document.querySelectorAll('main > section')) {
  const link = document.createElement('a');
  link.href = '#' + section.id;
  link.textContent = section.querySelector('h2').textContent;
  contents.append(link);
}

/// The text of an element that packed.cpp made.
async function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'))).text();
}

async function show(plot, specification) {
  try {
    await vegaEmbed(plot, specification, {
      renderer: 'svg',
      // The editor is a web site: this page asks the network for nothing.
      actions: {export: {svg: true, png: false}, source: false, compiled: false, editor: false},
    });
    plot.dataset.shown = 'yes';
  } catch (fault) {
    plot.dataset.shown = 'no';
    plot.textContent = 'This figure could not be drawn: ' + fault;
    console.error(fault);
  }
}

unpacked('specifications').then(JSON.parse)
    .then((all) => Promise.all([...document.querySelectorAll('[data-figure]')].map((plot) => show(plot, all[plot.dataset.figure]))))
    .then(() => { document.documentElement.dataset.complete = 'yes'; });
