// Contents list from the headings, then every figure from its specification. `data-shown` tells a test, or a reader's script, how each ended.
const contents = document.querySelector('nav');
for (const section of document.querySelectorAll('main > section')) {
  const link = document.createElement('a');
  link.href = '#' + section.id;
  link.textContent = section.querySelector('h2').textContent;
  contents.append(link);
}

const specifications = JSON.parse(document.getElementById('specifications').textContent);
const plots = [...document.querySelectorAll('[data-figure]')].map(async (plot) => {
  try {
    await vegaEmbed(plot, specifications[plot.dataset.figure], {
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
});
Promise.all(plots).then(() => { document.documentElement.dataset.complete = 'yes'; });
