// What the page shows, deflated as its pictures are: `json_text` of `document.py` makes it.

const documentData = JSON.parse(new TextDecoder().decode(await inflate(document.getElementById("data").textContent)));
